"""The built-in rules, one module a subject. `registry` finds them; nothing is listed by hand."""
