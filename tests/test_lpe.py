"""Is every light path expression read as its renderer reads it, and every oddity told?"""

from __future__ import annotations

import itertools
import re
import time
from collections.abc import Iterable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from usdrender_lint.lpe import (
    ALL,
    DIALECTS,
    OSL,
    Dialect,
    Expression,
    Problem,
    accepted_by,
    extensions,
    has_variable,
    looks_like_lpe,
    mended,
    parse,
    read,
    strip_prefix,
    suspicions,
)
from usdrender_lint.lpe.tree import (
    Choice,
    Either,
    Event,
    Except,
    Group,
    Label,
    Part,
    Repeat,
    Sequence,
    Symbol,
    walk,
)

EVERYONE = tuple(d.name for d in ALL)
ARNOLD, KARMA, MOONRAY, RENDERMAN, VRAY = (
    DIALECTS[name] for name in ("arnold", "karma", "moonray", "renderman", "vray")
)
CHARACTERS = "CLOBRTVDGSsUAMx.*+?{}[]()<>^|&-';:,0129 lpe"
PLACES = st.integers(0, 99)
BOUNDED = settings(derandomize=True, database=None, deadline=None, max_examples=60)


# -- who reads what


@pytest.mark.parametrize(
    ("text", "readers"),
    [
        # the guide's, and those of the catalogue of rules
        ("C<RD>[<L.>O]", EVERYONE),
        ("C[<L.>O]", EVERYONE),
        ("C<RD>[DS]+[<L.>O]", EVERYONE),
        ("C<TS>[DS]*[<L.>O]", EVERYONE),
        ("C.*<L.'key'>", EVERYONE),
        ("C<RD>L|C<TS>L", EVERYONE),
        ("CL", EVERYONE),
        ("CRDL", EVERYONE),
        ("C<D>L", EVERYONE),
        ("CDA", ("arnold", "karma")),
        ("unoccluded;C<RD>.*L", ("renderman", "karma", "moonray")),
        ("shadows;C[<.D><.S>]<L.>", ("renderman", "moonray")),
        ("C<RD>[<L.>O", ()),
        ("C<R<D>>L", ()),
        ("C<RD> L", ()),
        ("C**L", ()),
        ("C||L", ()),
        ("C<RD*>L", ()),
        ("C<RD>{,2}L", ()),
        ("beauty", ()),
        ("", ()),
        # every construct
        (".*", EVERYONE),
        ("C(<RD>|<TS>)L", EVERYONE),
        ("C[^LO]*L", EVERYONE),
        ("C[^'1''2'].+L", EVERYONE),
        ("CD{2}G{2,}S{0,3}sL", EVERYONE),
        ("C<RS[^'coat']'floor'>.*", EVERYONE),
        ("C'a label; with <anything>'L", EVERYONE),
        ("C[]L", EVERYONE),
        ("C()L", EVERYONE),
        ("C<>L", EVERYONE),
        ("C<xD>L", EVERYONE),
        ("C<RD1>L", EVERYONE),
        ("C<R D>L", EVERYONE),
        ("(CD)junk", ("osl", "arnold", "moonray")),
        ("CR?L", ("vray",)),
        ("C.*-(C<RD>L)&^(CL)", ("vray",)),
        ("CU2L", ("renderman",)),
        ("CS8+L", ("renderman",)),
        ("C[^D2D3]L", ("renderman",)),
        ("CT+U", ("renderman", "moonray")),
        ("CT+M", ("moonray",)),
        ("shadow;CL", ("renderman", "karma", "moonray", "vray")),
        ("nothruput;overwrite;CU6L", ("renderman",)),
        ("diffuse", ("renderman", "moonray")),
        ("unoccluded; caustic ", ("moonray",)),
        ("C[^]L", ()),
        ("C[^.]L", ()),
        ("C[^x]L", ()),
        ("C[^<L.>]L", ()),
        ("CxL", ()),
        ("C*+L", ()),
        ("C|L|", ()),
        ("lpe:CL", ()),
    ],
)  # fmt: skip
def test_each_text_is_read_by_those_who_do(text: str, readers: tuple[str, ...]) -> None:
    assert accepted_by(text) == readers


@pytest.mark.parametrize("dialect", ALL, ids=lambda d: d.name)
def test_what_a_renderer_ships_is_read_and_not_suspect(dialect: Dialect) -> None:
    for text in SHIPPED[dialect.name].split():
        expression = parse(text, dialect)
        assert isinstance(expression, Expression), (text, expression)
        assert (text, *suspicions(expression)) == (text,)


SHIPPED = {
    # accum_test.cpp, but for the types it adds itself
    "osl": "C[SG]*D*L C[SG]*D{2,3}L C[SG]*D*<L.'3'> C[SG]*<.D'1'>D*L C<.[SG]>+D*L CD+L CD+<Ts>L"
    " C<R[^D]>+D*L C([SG]*D){1,2}L",
    # rman_dspychan_definitions.json of RenderMan for Blender; the tables of rmanwiki.pixar.com
    "renderman": "C[<.D><.S>][DS]*[<L.>O] C<.D><L.> (C<RD>[DS]+<L.>)|(C<RD>[DS]*O)"
    " C<RS>([DS]+<L.>)|([DS]*O) (C<T[S]>[DS]+<L.>)|(C<T[S]>[DS]*O) emission"
    " shadows;C[<.D><.S>]<L.> nothruput;noinfinitecheck;noclamp;unoccluded;overwrite;C(U2L)|O"
    " nothruput;noinfinitecheck;noclamp;unoccluded;overwrite;C<.S'passthru'>*((U2L)|O)"
    " C<.D>[S]+<L.> holdouts;unoccluded;C[DS]+<L.> C(D[DS]*[LO])|[LO] C(D[DS]*[LO])|O CS[DS]*[LO]"
    " CD2[DS]+[<L.>O] C<RS8>[<L.>O] C<TS8>[DS]*[<L.>O] CD|(SD)L C(DS)L C[S2S3S4]L C[^D2D3]L"
    " C<T[DS]>{2}[LO] C[DS]{2,}[LO] C[DGS]<L.'tiny'> C.L CR[LO]",
    # help.autodesk.com: the built-in expressions
    "arnold": "C.* C[DSV]L C[DSV][DSVOB].* C[LO] CB C<RD>.* C<RS[^'coat']>.* C<RS'coat'>.* C<TD>.*"
    " CV.* C[DSV]A ((C<TD>A)|(CVA)|(C<RD>A)) C<RD>[DSVOB].* C[ST].*[LO] C.*<L.'pt'>",
    # Houdini's standard render vars, and more of them in circulation
    "karma": "C.* C<RD>.*L CDA unoccluded;C<RD>.+L C<RG>A shadow;C<RG>*L C<...'coat'>.*L CV.+L CL"
    " shadow;C.*[LO] C<TG>.*[<L.><O>] C<TG>*DA C<TG>..+<RD>.*L C<TG>[^O]*L C.*R+.*O"
    " C<TG>[<TG><RG>]+O",
    # docs.openmoonray.org
    "moonray": "CT+U CT+U'U:my_extra_aov_label' CT+'U:my_extra_aov_label' reflection caustic"
    " unoccluded;CD[<L.>O] C<RD>[DSG]+[<L.>O]",
    # docs.chaos.com: the presets
    "vray": "C.* C[OL] CB C<RD>L C<R[GS]>L C<RD>(.+L|.*[OB]) C<TD>.+L CR?L CR'1'.+L"
    " CR[^'1''2'].+L C.'m1'.* C<R[GS]'m1'>.'m1'+L C<[RT][SG]>+<TD>.+L C<RD[^'1']>L shadow;C.*L",
}


# -- what is said of the others


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("", 1, "the expression is empty"),
        ("unoccluded;", 12, "the expression is missing after the prefix"),
        ("lpe:CL", 1, "'lpe:' is no part of the expression: it comes from sourceType"),
        ("C<RD> L", 6, "a space is not allowed"),
        (" CL", 1, "a space is not allowed"),
        ("CL\n", 3, "a line break is not allowed"),
        ("C\u00a0L", 2, "U+00A0 has no meaning here"),
        ("C<RD>[<L.>O", 6, "'[' is never closed"),
        ("C(<RD>[LO]", 2, "'(' is never closed"),
        ("C<RD", 2, "'<' is never closed"),
        ("C[^LO", 2, "'[' is never closed"),
        ("C.{2", 3, "'{' is never closed"),
        ("C.*<L.'key>", 7, "the quote of this label is never closed"),
        ("CL)", 3, "')' closes nothing"),
        ("C(<RD>]L)", 7, "']' closes nothing: '(' of column 2 waits for its ')'"),
        ("C<R<D>>L", 4, "'<' inside '< >'"),
        ("C<RD*>L", 5, "'*' inside '< >': only the whole event can be repeated"),
        ("C**L", 3, "'**': one repetition only"),
        ("C.{2,3}+L", 8, "'{2,3}+': one repetition only"),
        ("*L", 1, "'*' has nothing to repeat"),
        ("C(+)L", 3, "'+' has nothing to repeat"),
        ("|CL", 1, "'|' has nothing to its left"),
        ("C||L", 2, "'|' has nothing to its right"),
        ("C(L|)", 4, "'|' has nothing to its right"),
        ("C[L|O]", 4, "'|' inside '[ ]': there every item is an alternative already"),
        ("C[^]L", 2, "'[^]' excludes nothing"),
        ("C[^.]L", 4, "'.' cannot be excluded"),
        ("C[^<L.>]", 4, "'[^ ]' excludes letters and labels, not '<'"),
        ("C^L", 2, "'^' belongs right after '[', as in [^LO]"),
        ("C<RD>{,2}L", 7, "a number is missing before ',': {0,2} is from none to two"),
        ("C.{a}L", 4, "'a' in '{ }': it holds one number or two, {2} or {2,5}"),
        ("C.{}L", 4, "'}' in '{ }': it holds one number or two, {2} or {2,5}"),
        ('C.*<L."key">"', 13, "labels are quoted with ', not with \""),
        ("CxL", 2, "'x' (none) stands only inside '< >'"),
        ("beauty", 1, "'beauty' is a name, not an expression"),
        ("Ci", 1, "'Ci' is a name, not an expression"),
        ("CdL", 2, "'d' is no event: D is"),
        ("CQL", 2, "'Q' is no event: there are C L O B R T V, and scatterings D G S s"),
        ("\u0421L", 1, "'\u0421' (U+0421) only looks like C"),
        ("C.{2}\u2019key\u2019", 6, "'\u2019' (U+2019) only looks like '"),
        ("$lgL", 1, "'$': is a variable left that nothing has replaced?"),
        ("C1L", 2, "'1' has no meaning here"),
        ("C<RD>L;", 7, "';' has no meaning here"),
        ("(" * 60, 51, "nested more than 50 deep"),
    ],
)  # fmt: skip
def test_a_problem_names_its_column(text: str, column: int, message: str) -> None:
    assert read(text) == Problem(message, column)


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("CDA", 3, "only Arnold and Karma read 'A' (albedo)"),
        ("CR?L", 3, "only V-Ray reads '?': write {0,1}"),
        ("C.*-CL", 4, "only V-Ray combines expressions by '-'"),
        ("CD2L", 3, "'D2': only RenderMan numbers its lobes"),
        ("shadows;CL", 1, "only RenderMan reads the prefix 'shadows;'"),
        ("unocluded;CL", 1, "'unocluded;' is no prefix: did you mean 'unoccluded;'?"),
    ],
)
def test_what_others_read_is_said_so(text: str, column: int, message: str) -> None:
    assert parse(text, OSL) == Problem(message, column)


# -- what it is made of


def test_the_tree() -> None:
    expression = parse("C<RD'x'>(L|O)*[^S]", OSL)
    assert isinstance(expression, Expression)
    alternatives = Either((Sequence((Symbol("L"),)), Sequence((Symbol("O"),))), "|")
    assert expression.body == Sequence(
        (
            Symbol("C"),
            Event((Symbol("R"), Symbol("D"), Label("x"))),
            Repeat(Group(Sequence((alternatives,))), "*", 0, None),
            Except((Symbol("S"),)),
        )
    )


def test_a_bar_joins_two_neighbours_but_in_v_ray() -> None:
    assert _options("CD|SL", OSL) == [["D", "S"]]
    assert _options("C|D|SL", OSL) == [["C", "D", "S"]]
    assert _options("CD|SL", VRAY) == [["CD", "SL"]]


def _options(text: str, dialect: Dialect) -> list[list[str]]:
    expression = parse(text, dialect)
    assert isinstance(expression, Expression)
    found = (part for part in walk(expression.body) if isinstance(part, Either))
    return [[str(option) for option in either.options] for either in found]


# -- what is read and not meant


@pytest.mark.parametrize(
    ("text", "dialect", "column", "message", "meant"),
    [
        ("CRDL", OSL, 2, "'RD' is two bounces: one of that kind is <RD>", "C<RD>L"),
        ("CTSL", OSL, 2, "'TS' is two bounces: one of that kind is <TS>", "C<TS>L"),
        ("C<D>L", OSL, 2,
         "'D' is a scattering in the place of the event: it matches nothing", "C<.D>L"),
        ("C<DR>L", OSL, 2,
         "'D' is a scattering in the place of the event: it matches nothing", "C<RD>L"),
        ("C<[DS]>L", OSL, 2,
         "'D' is a scattering in the place of the event: it matches nothing", "C<.[DS]>L"),
        ("C<RT>L", OSL, 4, "'T' is no scattering: D G S s are", "C<[RT].>L"),
        ("C<QD>L", OSL, 3, "no event is called 'Q'", None),
        ("C<LD>", OSL, 2, "'L' never has the scattering 'D'", "C<L.>"),
        ("C<RDS>L", OSL, 5, "'S' is taken for a label, as all from the third place on",
         "C<R[DS]>L"),
        ("C<L'key'>", OSL, 2,
         "'key' stands where the scattering belongs: labels are third, as in <L.'key'>",
         "C<L.'key'>"),
        ("C.*<'key'>", OSL, 4,
         "'key' stands where the event belongs: labels are third, as in <L.'key'>",
         "C.*<..'key'>"),
        ("C.*L'key'", OSL, 5, "nothing is left for 'key': the path has ended", "C.*<L.'key'>"),
        ("C<R D>L", OSL, 4, "a space inside '< >' is taken for a name that nothing has", "C<RD>L"),
        ("C<\u0422D>L", OSL, 3, "'\u0422' (U+0422) only looks like T", "C<TD>L"),
        ("C<L.\u2018key\u2019>", OSL, 5, "'\u2018' (U+2018) only looks like '", "C<L.'key'>"),
        ("C<>L", OSL, 2, "'<>' is any event, '.'", "C.L"),
        ("C<L.''>", OSL, 5, "this label is empty", None),
        ("C[]L", OSL, 2, "'[]' matches nothing", None),
        ("C()L", OSL, 2, "'()' holds nothing: Open Shading Language can crash on it", None),
        ("CD{0}L", OSL, 2,
         "'{0}' is no times at all: Open Shading Language can crash on it", None),
        ("CD{3,1}L", OSL, 2, "'{3,1}' counts backwards", "CD{1,3}L"),
        ("C[^RD]L", OSL, 2,
         "'[^RD]' mixes events and scatterings: all are taken for scatterings", None),
        ("<RD>L", OSL, 1, "'<RD>' cannot be first: a path begins at the camera, C", "C<RD>L"),
        ("LDC", OSL, 1, "'L' cannot be first: a path begins at the camera, C", None),
        ("C<RD>", OSL, 2, "no path ends in '<RD>': it ends in L, O or B, or '.*'", None),
        ("C[DG]*", KARMA, 2, "no path ends in '[DG]*': it ends in L, O, B or A, or '.*'", None),
        ("C<.D>", OSL, 2, "no path ends in '<.D>': it ends in L, O or B, or '.*'", None),
        ("C.*[^LOB]", OSL, 4, "no path ends in '[^LOB]': it ends in L, O or B, or '.*'", None),
        ("[^C]DL", OSL, 1, "'[^C]' cannot be first: a path begins at the camera, C", "C[^C]DL"),
        ("C[^RTV]D", OSL, 8, "nothing is left for 'D': the path has ended", None),
        ("C.*L{2}", OSL, 4, "no path has 'L{2}'", None),
        ("C&L", VRAY, 1, "no path has 'C&L'", None),
        ("C.*C", OSL, 4, "'C' can only be first", None),
        ("CLD", OSL, 3, "nothing is left for 'D': the path has ended", None),
        ("C(D(LS))L", OSL, 6, "nothing is left for 'S': the path has ended", None),
        ("C[^CLOBRTV]L", OSL, 2, "no path has '[^CLOBRTV]'", None),
        ("C.*[DL]O", OSL, 6, "'L' ends the path, and more is asked for after it", None),
        ("CL|DO", OSL, 2, "'L' ends the path, and more is asked for after it", None),
        ("CLD*", OSL, 3, "nothing is left for 'D': the path has ended", None),
        ("C<RD>L|C<TS>L", OSL, 6,
         "'|' joins just the two beside it, 'L|C': a longer alternative needs parentheses of its own",
         "((C<RD>L)|(C<TS>L))"),
        ("C<RD>L|C<TS>L", RENDERMAN, 6,
         "'|' joins just the two beside it, 'L|C': a longer alternative needs parentheses of its own",
         "(C<RD>L)|(C<TS>L)"),
        ("C<RD>(.+L|.*[OB])", OSL, 9,
         "'|' joins just the two beside it, 'L|.*': "
         "a longer alternative needs parentheses of its own", "C<RD>((.+L)|(.*[OB]))"),
        ("(C<RD>L)|(C<TS>L)", OSL, 9,
         "Open Shading Language reads only to the ')' that closes the first '(': "
         "'|(C<TS>L)' is lost", "((C<RD>L)|(C<TS>L))"),
        ("(CD)junk", OSL, 5,
         "Open Shading Language reads only to the ')' that closes the first '(': 'junk' is lost",
         None),
        ("C<RS>L", KARMA, 4, "Karma has no 'S': it calls that G", "C<RG>L"),
        ("CS+L", KARMA, 2, "Karma has no 'S': it calls that G", "CG+L"),
        ("CD9L", RENDERMAN, 2, "'D9': RenderMan has D1 to D4", None),
        ("shadow;CL", RENDERMAN, 1, "only Karma and V-Ray read the prefix 'shadow;'",
         "shadows;CL"),
        ("shadows;CL", MOONRAY, 1, "only RenderMan reads the prefix 'shadows;'", None),
    ],
)  # fmt: skip
def test_a_suspicion_names_its_column(
    text: str, dialect: Dialect, column: int, message: str, meant: str | None
) -> None:
    expression = parse(text, dialect)
    assert isinstance(expression, Expression)
    found = [(s.column, s.message, s.meant(text)) for s in suspicions(expression)]
    assert found == [(column, message, meant)]
    assert mended(expression) == meant


@pytest.mark.parametrize(
    ("text", "dialect", "columns", "meant"),
    [
        ("sahdows;CRS2<L'key'>", RENDERMAN, [1, 10, 13], "shadows;C<RS2><L.'key'>"),
        ("CRSL", KARMA, [2, 3], "C<RG>L"),
        ("C<S>L", KARMA, [2], "C<.G>L"),
        ("C<D>L|C<TS>L", OSL, [2, 5], "((C<.D>L)|(C<TS>L))"),
        ("C.*<D>", OSL, [4], None),
        ("CRD<>", OSL, [2, 4], "C<RD>."),
    ],
)
def test_all_that_is_wrong_is_mended_together(
    text: str, dialect: Dialect, columns: list[int], meant: str | None
) -> None:
    expression = parse(text, dialect)
    assert isinstance(expression, Expression)
    assert [s.column for s in suspicions(expression)] == columns
    assert mended(expression) == meant


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        ("CL", OSL),
        ("CL.*", OSL),
        ("C.+", OSL),
        ("C(D|SL).*", OSL),
        ("C<V.>L", OSL),
        ("C<RD1>L", OSL),
        ("C'key'", OSL),
        ("CL'key'", VRAY),
        ("(C<RD>L)|(C<TS>L)", VRAY),
        ("C.*-(C<RD>L)", VRAY),
        ("C[^D].*", OSL),
    ],
)
def test_what_may_be_meant_is_not_suspect(text: str, dialect: Dialect) -> None:
    expression = parse(text, dialect)
    assert isinstance(expression, Expression)
    assert list(suspicions(expression)) == []


def test_only_what_is_nested_counts_as_deep() -> None:
    assert isinstance(parse("C" + "(D)[G]<RS>" * 60 + "L", OSL), Expression)
    assert isinstance(parse("|".join(["^CL"] * 60), VRAY), Expression)


# -- whose it is


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("C<RD>[<L.>O]", []),
        ("C<RDA>L", []),
        ("CDA", [("the event 'A' (albedo)", 3, "arnold karma")]),
        ("C.*<A.>", [("the event 'A' (albedo)", 5, "arnold karma")]),
        ("shadows;CL", [("the prefix 'shadows;'", 1, "renderman")]),
        ("C<RS8>L", [("the numbered lobe 'S8'", 4, "renderman")]),
        ("CU2L", [("the event 'U2'", 2, "renderman")]),
        ("CR?L", [("the repetition '?'", 3, "vray")]),
        ("CL&^(CD)", [("the operator '&'", 1, "vray"), ("the operator '^'", 4, "vray")]),
        ("diffuse", [("the name 'diffuse'", 1, "renderman moonray")]),
        ("C<RD>[<L.>O", []),
    ],
)
def test_extensions(text: str, found: list[tuple[str, int, str]]) -> None:
    told = [(e.what, e.column, " ".join(d.name for d in e.dialects)) for e in extensions(text)]
    assert told == found


def test_read_prefers_open_shading_language_then_the_least_odd() -> None:
    assert _dialect("(CL)|(CO)") is OSL
    assert _dialect("shadow;C<RS>L") is VRAY
    assert _dialect("shadow;C<RG>L") is KARMA
    assert _dialect("C<RS>A") is ARNOLD
    # the reader that came furthest says what is wrong
    assert read("unoccluded;C[L") == Problem("'[' is never closed", 13)
    assert read("CL", ()) == Problem("no renderer reads it", 1)


def _dialect(text: str) -> Dialect:
    expression = read(text)
    assert isinstance(expression, Expression)
    return expression.dialect


# -- expressions under another name


@pytest.mark.parametrize(
    ("text", "looks"),
    [
        ("C<RD>[<L.>O]", True),
        ("lpe:C<RD>L", True),
        ("lpe:beauty", True),
        ("C.*", True),
        ("C[LO]", True),
        ("(C<RD>L)|(C<TS>L)", True),
        ("<C.>D+L", True),
        ("shadows;C[DS]+<L.>", True),
        ("CR+A", True),
        # names, and what is none of both
        ("CL", False),
        ("CDA", False),
        ("Ci", False),
        ("LdrColor", False),
        ("crypto_object00", False),
        ("primvars:st", False),
        ("", False),
        (".*", False),
        ("C<RD>[<L.>O", False),
        ("<RD>L", False),
        ("Cs[0]", False),
        ("a*b", False),
        ("[]", False),
    ],
)
def test_looks_like_lpe(text: str, looks: bool) -> None:
    assert looks_like_lpe(text) is looks


def test_the_prefix_is_stripped_however_often_it_stands_there() -> None:
    assert strip_prefix("lpe:CL") == "CL"
    assert strip_prefix("lpe:lpe:CL") == "CL"
    assert strip_prefix("CL") == "CL"
    assert strip_prefix("lpe") == "lpe"
    assert strip_prefix("Clpe:") == "Clpe:"


def test_variables() -> None:
    assert all(map(has_variable, ("C.*<L.'$lg'>", "C<L.'${LG}'>", "`chs('lpe')`")))
    assert not any(map(has_variable, ("C.*<L.'key'>", "$", "C<RD>L$")))


# -- whatever the text


def _sequences(dialect: Dialect) -> st.SearchStrategy[str]:
    lobes = [f"{letter}{n}" for letter in dialect.lobes for n in (1, 4, 12)]
    labels = ["'key'", "'a b'", "'<[('", "'\u00e9'", "'7'"]
    named = st.sampled_from([*dialect.letters, *lobes, *labels])
    excepted = st.lists(named, min_size=1, max_size=3).map(lambda s: f"[^{''.join(s)}]")
    simple = st.one_of(named, st.just("."), excepted)
    slot = st.one_of(simple, st.lists(simple, max_size=2).map(lambda s: f"[{''.join(s)}]"))
    event = st.lists(slot, max_size=4).map(lambda s: f"<{''.join(s)}>")
    marks = ["", "", "*", "+", "{0}", "{2}", "{1,}", "{2,3}", "{3,2}", *"?" * dialect.optional]
    mark = st.sampled_from(marks)
    bar = st.sampled_from(dialect.operators)

    def nested(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        item = st.builds(str.__add__, inner, mark)
        several = st.lists(item, max_size=3).map("".join)
        joined = st.builds("({}{}{})".format, item, bar, item)
        return st.one_of(several.map("({})".format), several.map("[{}]".format), joined)

    item = st.recursive(st.one_of(simple, event), nested, max_leaves=6)
    return st.lists(st.builds(str.__add__, item, mark), min_size=1, max_size=4).map("".join)


def _expressions(dialect: Dialect) -> st.SearchStrategy[str]:
    prefixes = st.sampled_from(["", *(f"{name};" for name in sorted(dialect.prefixes))])
    return st.builds(str.__add__, prefixes, _sequences(dialect))


EXPRESSIONS = {dialect.name: _expressions(dialect) for dialect in ALL}


@pytest.mark.parametrize("dialect", ALL, ids=lambda d: d.name)
def test_what_the_grammar_makes_is_read_and_written_as_it_was(dialect: Dialect) -> None:
    @BOUNDED
    @given(EXPRESSIONS[dialect.name])
    def holds(text: str) -> None:
        expression = parse(text, dialect)
        assert isinstance(expression, Expression), expression
        assert str(expression) == text
        assert parse(str(expression), dialect) == expression
        for part in walk(expression.body):
            assert text.startswith(str(part), part.column - 1)
        for suspicion in suspicions(expression):
            assert 1 <= suspicion.column <= len(text)
            assert suspicion.meant(text) != text

    holds()


@pytest.mark.parametrize("dialect", ALL, ids=lambda d: d.name)
def test_what_is_mended_is_read_and_clean(dialect: Dialect) -> None:
    @BOUNDED
    @given(st.text("CLRTDS.<>'k*|()[]", max_size=12))
    def holds(text: str) -> None:
        expression = parse(text, dialect)
        if isinstance(expression, Expression) and (meant := mended(expression)) is not None:
            again = parse(meant, dialect)
            assert isinstance(again, Expression)
            assert not list(suspicions(again))

    holds()


@pytest.mark.parametrize("dialect", ALL, ids=lambda d: d.name)
def test_a_broken_one_is_read_or_names_a_column(dialect: Dialect) -> None:
    @BOUNDED
    @given(EXPRESSIONS[dialect.name], PLACES, st.integers(0, 2), st.text(CHARACTERS, max_size=2))
    def holds(text: str, at: int, less: int, more: str) -> None:
        at %= len(text) + 1
        _is_judged(text[:at] + more + text[at + less :], dialect)

    holds()


@BOUNDED
@given(st.one_of(st.text(), st.text(CHARACTERS, max_size=20)))
def test_no_text_raises(text: str) -> None:
    for dialect in ALL:
        _is_judged(text, dialect)
    problem = read(text)
    assert isinstance(problem, Problem) is not bool(accepted_by(text))
    extensions(text)
    looks_like_lpe(text)
    has_variable(strip_prefix(text))


def _is_judged(text: str, dialect: Dialect) -> None:
    expression = parse(text, dialect)
    if isinstance(expression, Problem):
        assert 1 <= expression.column <= len(text) + 1
        assert expression.message
    else:
        assert str(expression) == text
        for suspicion in suspicions(expression):
            assert 1 <= suspicion.column <= len(text)


@pytest.mark.parametrize(
    "text",
    [
        "(" * 100_000,
        "(" * 100_000 + ")" * 100_000,
        "C[" * 100_000,
        "^" * 100_000,
        "C.{" + "9" * 100_000,
        "'" * 9_999,
        "abc" * 30_000,
        "C" + "RD" * 2_000 + "L",
        "C" + "|C" * 2_000,
        "C<" + "R" * 4_000 + ">L",
        "C[" + "L" * 4_000 + "D]L",
        "C" + "(" * 40 + "(R|T)*" * 500 + ")" * 40 + "L",
        "a;" * 2_000 + "CL",
        "C.{" + "9" * 5_000 + "}L",
    ],
    ids=lambda t: f"{t[:6]}-{len(t)}",
)
def test_length_and_depth_cost_no_more_than_their_share(text: str) -> None:
    start = time.process_time()
    for dialect in ALL:
        _is_judged(text, dialect)
    read(text)
    assert time.process_time() - start < 5


# -- the same, by regular expressions of Python

SCATTERED = [f"{event}{scattering}" for event in "RT" for scattering in "DS"]
EVENTS = ["C", "L", "O", "B", "V", *SCATTERED]
CODES = {event: chr(ord("a") + i) for i, event in enumerate(EVENTS)}
PATHS = [
    "".join(CODES[event] for event in ("C", *bounces, end))
    for count in range(4)
    for bounces in itertools.product(("V", *SCATTERED), repeat=count)
    for end in "LOB"
]


def _pattern(part: Part) -> str:
    """Over paths of which each event is one character."""
    match part:
        case Symbol(text="."):
            return "."
        case Symbol():
            return _any(e for e in EVENTS if part.text in e)
        case Except():
            return _any(e for e in EVENTS if not any(str(i) in e for i in part.items))
        case Event():
            tests = [re.compile(f"{_slot(slot)}") for slot in part.slots]
            return _any(
                e for e in EVENTS if all(t.match(e[i : i + 1]) for i, t in enumerate(tests))
            )
        case Choice():
            return f"(?:{'|'.join(map(_pattern, part.items))})"
        case Either():
            return f"(?:{'|'.join(map(_pattern, part.options))})"
        case Group():
            return f"(?:{_pattern(part.body)})"
        case Repeat():
            return f"(?:{_pattern(part.item)}){part.mark}"
        case Sequence():
            return "".join(map(_pattern, part.items))
        case _:
            raise AssertionError(part)


def _slot(slot: Part) -> str:
    return "(?s:.)?" if str(slot) == "." else str(slot)


def _any(events: Iterable[str]) -> str:
    codes = "".join(CODES[event] for event in events)
    return f"[{codes}]" if codes else "(?!)"


PROPER = st.recursive(
    st.sampled_from([*"CLOBVRTDS...", "<RD>", "<.S>", "<[RT]D>", "<L.>", "[^L]", "[^CRT]", "[^D]"]),
    lambda inner: st.one_of(
        st.builds(str.__add__, inner, st.sampled_from(["*", "+", "{2}", "{1,2}", "{0,1}"])).filter(
            lambda t: not re.search(r"[*+}][*+{]", t)
        ),
        st.lists(inner, min_size=1, max_size=3).map(lambda s: f"[{''.join(s)}]"),
        st.lists(inner, min_size=1, max_size=3).map(lambda s: f"({''.join(s)})"),
        st.builds("({}|{})".format, inner, inner),
    ),
    max_leaves=5,
)


@settings(BOUNDED, max_examples=200)
@given(st.lists(PROPER, min_size=1, max_size=4).map(lambda s: f"C{''.join(s)}"))
def test_what_is_said_to_match_nothing_matches_nothing(text: str) -> None:
    """And a part that no path is said to take may as well be missing."""
    expression = parse(text, OSL)
    assert isinstance(expression, Expression)
    matched = _matched(_pattern(expression.body))
    for suspicion in suspicions(expression):
        if suspicion.message.startswith("'|'") or "two bounces" in suspicion.message:
            continue
        assert not matched or _without(expression, suspicion.column) == matched, suspicion


def _matched(pattern: str) -> list[str]:
    compiled = re.compile(pattern)
    return [path for path in PATHS if compiled.fullmatch(path)]


def _without(expression: Expression, column: int) -> list[str]:
    """What is matched if the largest part there matches nothing, that has a choice beside it."""
    results = []
    for part in walk(expression.body):
        if part.column == column:
            text = str(expression)
            start, end = column - 1, column - 1 + len(str(part))
            read = parse(f"{text[:start]}[^CLOBVRT]{text[end:]}", OSL)
            if isinstance(read, Expression):
                results.append(_matched(_pattern(read.body)))
    whole = _matched(_pattern(expression.body))
    return whole if whole in results else []
