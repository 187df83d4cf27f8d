"""How is the work shared among processes, so that a file on which USD dies costs only itself?"""
