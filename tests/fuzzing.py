"""Files that nobody would write, and what a report of any of them must not be.

Run by `test_fuzz.py`. `python tests/fuzzing.py FILE...` is its other half: it lints each file and
tells in a line of JSON what there is to complain of, in a process that USD may bring down.
"""

from __future__ import annotations

import faulthandler
import json
import random
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from pxr import Sdf, Usd

from usdrender_lint.formats import FORMATS, Style, render
from usdrender_lint.lint import lint
from usdrender_lint.model import RENDER_TYPES
from usdrender_lint.results import Report

Random = random.Random

CPU_SECONDS = 5.0
"""For one file of a few KB; counted in CPU time, so that no busy machine fails a test."""
HANG = 20.0
"""CPU seconds after which it is USD that hangs, where no Python interrupts it."""
DEADLOCK = 300.0
"""Seconds by the clock after which it waits for itself."""
MEMORY = 2 << 30
"""Damaged sizes ask for any amount."""


def complaints(file: Path) -> list[str]:
    """What a report of any file at all must not hold."""
    report = lint([str(file)], cwd=file.parent)
    found = [f"{p.kind}: {p.message}" for p in report.problems if p.kind.startswith("crashed")]
    found += [chatter for chatter in report.chatter if found and "Traceback" in chatter]
    for finding in report.findings:
        at = finding.location
        told = f"[{finding.rule.id}] {finding.message} <{finding.prim_path}.{finding.property}>"
        if not Path(at.file).is_file():
            found.append(f"no layer: {told} {at}")
        if Path(at.file).suffix == ".usda" and at.span is None:
            found.append(f"no line: {told}")
        if "pxr" in finding.message or "::" in finding.message:
            found.append(f"C++: {told}")
    fails = bool(report.problems) or any(map(report.fails, report.findings))
    if not fails and not opens(file):
        found.append("passes, though USD does not open it")
    return found + unrendered(report)


def unrendered(report: Report) -> list[str]:
    found = []
    for name in FORMATS:
        try:
            text = render(report, name, None, Style(False, False, True))
            if name in ("json", "sarif", "gitlab"):
                json.loads(text)
        except Exception as error:  # noqa: BLE001 whatever it is
            found.append(f"{name}: {error!r}")
    return found


def opens(file: Path) -> bool:
    """The stage, and each layer right below its root."""
    try:
        stage = Usd.Stage.Open(str(file), Usd.Stage.LoadNone)
        layer = stage.GetRootLayer()
        below = [layer.ComputeAbsolutePath(asset) for asset in layer.subLayerPaths]
        return all(Sdf.Layer.FindOrOpen(one) for one in below)
    except Exception:  # noqa: BLE001 whatever USD raises
        return False


def damaged(data: bytes, random: Random) -> bytes:
    """Cut off, with flipped bits, other bytes, a hole, a block twice, or two blocks swapped."""
    found = bytearray(data)
    size = len(found)

    def block(longest: int) -> slice:
        start = random.randrange(size)
        return slice(start, min(size, start + random.randrange(1, longest)))

    match random.randrange(6):
        case 0:
            del found[random.randrange(size) :]
        case 1:
            for _ in range(random.randrange(1, 6)):
                found[random.randrange(size)] ^= 1 << random.randrange(8)
        case 2:
            for _ in range(random.randrange(1, 6)):
                found[random.randrange(size)] = random.randrange(256)
        case 3:
            del found[block(60)]
        case 4:
            at = random.randrange(size)
            found[at:at] = found[block(400)]
        case _:
            one, other = block(30), block(30)
            found[one], found[other] = found[other], found[one]
    return bytes(found)


def reworded(data: bytes, random: Random) -> bytes:
    """usda with words swapped, doubled or dropped, which mostly still parses."""
    words = data.replace(b"\n", b" \n ").split(b" ")
    for _ in range(random.randrange(1, 8)):
        one, other = random.randrange(len(words)), random.randrange(len(words))
        match random.randrange(4):
            case 0:
                words[one], words[other] = words[other], words[one]
            case 1:
                words[one] = words[other]
            case 2:
                words.insert(one, words[other])
            case _:
                words[one] = b""
    return b" ".join(words)


VALUES = {
    "int": ["-1", "0", "2147483647"],
    "int2": ["(0, 0)", "(-1, 2147483647)"],
    "float": ["nan", "inf", "-inf", "1e-30", "0"],
    "double": ["nan", "1e308"],
    "half": ["inf", "65504"],
    "float4": ["(nan, inf, -inf, 0)", "(1, 1, 0, 0)", "(0, 0, 1e38, 1e38)"],
    "bool": ["true", "0"],
    "token": ['""', '"\u2028\U0001f600"', '"a b"', '"/x"', '"<F4>"', '"%s%s{}"', '"lpe:C<RD"'],
    "string": ['""', '"C[DS]*<L.\'a\'>"', "'''\n\n'''", '"\\x07"', '"`${X}`"', f'"{"<" * 300}"'],
    "asset": ["@@", "@x.usda@", "@`\"${X}\"`@", "@@@a@b@@@"],
    "token[]": ["[]", '["", "", "a"]', "[" + ", ".join(['"x"'] * 500) + "]"],
    "string[]": ['["a"]', "[]"],
    "int[]": ["[]", "[1, 2, 3]", "[" + ", ".join(["7"] * 5000) + "]"],
    "matrix4d": ["((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))"],
    "color3f": ["(0, 0, 0)"],
    "timecode": ["1"],
    "pathExpression": [
        '"//"', '"/World//{Camera}"', '"~//"', '"%_ + /a"', '"%:prune"', '"/a//b//c*"',
        '"' + "~(" * 60 + "/a" + ")" * 60 + '"',
    ],
    "dictionary": ["{\n}"],
    "opaque": [],
}  # fmt: skip
"""What may be said in each type."""

PATHS = [
    "/Render", "/Render/S", "/Render/P", "/Render/v", "/Render/A", "/Render/B", "/World", "/World/cam",
    "/Render/S.camera", "/Render/S.products", "/Render/P.orderedVars", "/Render/A.inputPasses",
    "/Render/B.inputPasses", "/Render/x.f", "/Render/x.g", "/nope", "/nope.f", "/Render/A.collection:prune",
    "/Render/B.collection:prune", "/Render/A.collection:nope", "/World/cam.focalLength", "/Render/S/World/cam",
]  # fmt: skip
PRIMS = {"S": 0, "T": 0, "P": 1, "Q": 1, "v": 2, "w": 2, "A": 3, "B": 3}
"""Name to type, of `RENDER_TYPES`."""
OTHERS = ["x:y", "ri:a", "f", "g", "arnold:driver", "ü", "collection:prune", "a:b:c:d:e:f"]
METADATA = [
    "", "", "", "", "(active = false)", "(instanceable = true)", '(kind = "")', '(doc = """\n#\n""")',
    *(f"({arc} = <{at}>)" for arc in ("references", "payload", "inherits", "specializes")
      for at in ("/World", "/Render/S", "/Render/v", "/nope", "/Render")),
    "(references = @./SELF@</Render/P>)", "(payload = @./SELF@)", "(references = @./nope.usda@)",
    "(references = [@@, @./SELF@</Render/S>])",
    '(variants = {\n string q = "z"\n}\nprepend variantSets = "q")',
    '(apiSchemas = ["CollectionAPI:prune", "NoSuchAPI", "CollectionAPI"])',
    '(apiSchemas = ["CollectionAPI:a:b", "", "CollectionAPI:ü"])',
    "(customData = {\n dictionary usdrenderLint = {\n int ignore = 3\n}\n})",
    "(customData = {\n dictionary usdrenderLint = {\n token[] ignore = [\"all\", \"\", \"x y\"]\n}\n})",
    f"(customData = {{\n double[] huge = [{', '.join(['0.5'] * 9000)}]\n}})",
]  # fmt: skip
DEFAULTS = ['"/Render/S"', '"/Render/S"', '"/"', '""', '"<a>"', '"/Render/S.a"', '"/Render/ü"']


def made_up(random: Random, name: str) -> str:
    """A render spec in which every property may say anything, in any type, of any prim."""
    default = random.choice(DEFAULTS)
    lines = [f"#usda 1.0\n(\n    renderSettingsPrimPath = {default}"]
    if random.random() < 0.3:
        lines.append("    relocates = { </World/cam> : </World/moved> }")
    if random.random() < 0.2:
        lines.append(f"    subLayers = [@./{random.choice([name, 'nope.usda'])}@]")
    if random.random() < 0.2:
        lines.append('    expressionVariables = {\n        string X = "`${X}`"\n    }')
    lines.append(f')\n{random.choice(["def", "def", "over", "class"])} Scope "Render"\n{{')
    for child, kind in PRIMS.items():
        lines += _prim(random, child, RENDER_TYPES[kind])
    lines += _prim(random, "x", random.choice(["", "Scope", "Camera", "NoSuchType", "Mesh"]))
    depth = random.choice([0, 0, 1, 150])
    lines += [f'def Scope "g{i}"\n{{' for i in range(depth)]
    lines += _prim(random, random.choice(["ü", "v", "名"]), random.choice(RENDER_TYPES))
    lines += ["}"] * depth
    lines.append('}\ndef Xform "World"\n{')
    lines += _prim(random, "cam", random.choice(["Camera", "Camera", "Xform"]))
    lines.append("}")
    return "\n".join(lines).replace("SELF", name)


def _prim(random: Random, name: str, type_name: str) -> Iterator[str]:
    of = type_name if random.random() < 0.7 else random.choice(RENDER_TYPES)
    known = properties_of(of)
    names = {*random.sample(known, k=min(5, len(known))), *random.sample(OTHERS, k=2)}
    specifier = random.choice(["def", "def", "def", "over", "class"])
    yield f'    {specifier} {type_name} "{name}" {random.choice(METADATA)}\n    {{'
    said = [f"        {_statement(random, one)}" for one in sorted(names)]
    if random.random() < 0.2:
        yield from said[:2]
        yield '        variantSet "q" = {\n            "z" {'
        yield from said[2:]
        yield '            }\n            "y" {\n            }\n        }'
    else:
        yield from said
    yield "    }"


def _statement(random: Random, name: str) -> str:
    kind = random.choice([*VALUES, "rel", "rel", "rel"])
    if kind == "rel":
        edit = random.choice(["", "", "prepend ", "append ", "delete ", "add "])
        return f"{edit}rel {name}{_targets(random, bare=not edit)}"
    said = random.choice([*VALUES[kind], "None"])
    return random.choice(
        [
            lambda: f"{kind} {name}",
            lambda: f"{kind} {name}.connect = <{random.choice(PATHS)}>",
            lambda: f"{kind} {name}.timeSamples = {{ 1: {said}, 2: None, 3: {said} }}",
            lambda: f"uniform {kind} {name} = {said}",
            lambda: f"custom {kind} {name} = {said}",
            lambda: f"{kind} {name} = {said}",
        ]
    )()


def _targets(random: Random, *, bare: bool) -> str:
    listed = dict.fromkeys(random.choice(PATHS) for _ in range(random.randrange(1, 5)))
    told = f" = [{', '.join(f'<{path}>' for path in listed)}]"
    return random.choice(["", " = None", " = []", told, told, told]) if bare else told


def of_type(kind: str, how: str) -> str:
    """A render spec in which every property of the schema says something of that type."""
    said = {
        "value": " = {0}",
        "samples": ".timeSamples = {{ 1: {0}, 2: None }}",
        "block": " = None",
        "nothing": "",
    }[how]
    lines = ['#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/S"\n)\ndef Scope "Render"\n{']
    for name, number in PRIMS.items():
        lines.append(f'    def {RENDER_TYPES[number]} "{name}"\n    {{')
        for one in properties_of(RENDER_TYPES[number]):
            if kind == "rel":
                target = "None" if how == "block" else "[</World/cam>, </Render>, </nope>]"
                lines.append(f"        rel {one} = {target}")
            else:
                last = VALUES[kind][-1] if VALUES[kind] else "None"
                lines.append(f"        {kind} {one}{said.format(last)}")
        lines.append("    }")
    return "\n".join([*lines, '}\ndef Xform "World"\n{\n    def Camera "cam"\n    {\n    }\n}\n'])


def properties_of(type_name: str) -> list[str]:
    found = Usd.SchemaRegistry().FindConcretePrimDefinition(type_name)
    return sorted(found.GetPropertyNames()) if found else ["f", "g"]


@dataclass(frozen=True, slots=True)
class Seeds:
    """Whole files to damage."""

    texts: list[Path]
    crates: list[Path]
    packages: list[Path]


def seeds_of(texts: list[Path], folder: Path) -> Seeds:
    """Texts, and the same as crates and packages."""
    folder.mkdir()
    crates, packages = [], []
    for number, text in enumerate(texts):
        crate, package = folder / f"{number}.usdc", folder / f"{number}.usdz"
        Sdf.Layer.OpenAsAnonymous(str(text)).Export(str(crate))
        with Sdf.ZipFileWriter.CreateNew(str(package)) as writer:
            writer.AddFile(str(crate), "main.usdc")
            writer.AddFile(str(text), "other.usda")
        crates.append(crate)
        packages.append(package)
    return Seeds(texts, crates, packages)


Make = Callable[[Random, Seeds, Path, int], Path]
"""Writes one input; tells which file is to be linted."""


def _damaged(random: Random, seeds: list[Path], folder: Path, number: int) -> Path:
    seed = random.choice(seeds)
    file = folder / f"{number}{seed.suffix}"
    file.write_bytes(damaged(seed.read_bytes(), random))
    return file


def _sublayer(random: Random, seeds: Seeds, folder: Path, number: int) -> Path:
    whole = random.choice([seeds.texts, seeds.crates, seeds.packages])
    below = _damaged(random, whole, folder, number)
    file = folder / f"{number}_over.usda"
    text = random.choice(seeds.texts).read_text("utf-8")
    if "subLayers" not in text:
        text = text.replace("\n(\n", f"\n(\n    subLayers = [@./{below.name}@]\n", 1)
    file.write_text(text, "utf-8")
    return file


def _reworded(random: Random, seeds: Seeds, folder: Path, number: int) -> Path:
    file = folder / f"{number}.usda"
    file.write_bytes(reworded(random.choice(seeds.texts).read_bytes(), random))
    return file


def _made_up(random: Random, seeds: Seeds, folder: Path, number: int) -> Path:
    file = folder / f"{number}.usda"
    file.write_text(made_up(random, file.name), "utf-8")
    return file


def _made_up_crate(random: Random, seeds: Seeds, folder: Path, number: int) -> Path:
    text = _made_up(random, seeds, folder, number)
    file = text.with_suffix(".usdc")
    layer = Sdf.Layer.CreateAnonymous(".usda")
    try:
        layer.ImportFromString(text.read_text("utf-8").replace(text.name, file.name))
    except Exception:  # noqa: BLE001 whatever USD raises of what it does not read
        return text
    layer.Export(str(file))
    return file


def _of_type(random: Random, seeds: Seeds, folder: Path, number: int) -> Path:
    ways = [(k, h) for k in (*VALUES, "rel") for h in ("value", "samples", "block", "nothing")]
    file = folder / f"{number}.usda"
    file.write_text(of_type(*ways[number % len(ways)]), "utf-8")
    return file


KINDS: dict[str, Make] = {
    "text": lambda r, s, f, n: _damaged(r, s.texts, f, n),
    "crate": lambda r, s, f, n: _damaged(r, s.crates, f, n),
    "package": lambda r, s, f, n: _damaged(r, s.packages, f, n),
    "sublayer": _sublayer,
    "words": _reworded,
    "made up": _made_up,
    "made up, as a crate": _made_up_crate,
    "types": _of_type,
}


@dataclass(slots=True)
class Outcome:
    """What came of many files."""

    complaints: dict[str, list[str]] = field(default_factory=dict)
    """By file."""
    died: dict[str, int] = field(default_factory=dict)
    """Exit codes of the processes that USD brought down, by the file that they were at."""


def judged(files: list[Path]) -> Outcome:
    """Where a process dies or hangs, USD does: it is begun anew behind the file that it was at."""
    outcome = Outcome()
    rest = [str(file) for file in files]
    while rest:
        done = subprocess.run([sys.executable, __file__, *rest[:200]], capture_output=True)
        told = [json.loads(line) for line in done.stdout.decode().splitlines()]
        outcome.complaints.update((file, said) for file, said in told if said)
        batch = len(rest[:200])
        if len(told) < batch:
            if b"Traceback" in done.stderr:
                outcome.complaints[rest[len(told)]] = [done.stderr.decode(errors="replace")]
            outcome.died[rest[len(told)]] = done.returncode
        rest = rest[min(len(told) + 1, batch) :]
    return outcome


def keep(outcome: Outcome, folder: Path) -> None:
    """The files that something came of, for who wants to look at them."""
    folder.mkdir(parents=True, exist_ok=True)
    for file in {*outcome.complaints, *outcome.died}:
        shutil.copy(file, folder)


def _too_slow(number: int, frame: FrameType | None) -> None:
    raise TimeoutError(f"took more than {CPU_SECONDS:g} s")


def _limit_memory() -> None:
    if sys.platform == "linux":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def main(files: list[str]) -> None:
    _limit_memory()
    signal.signal(signal.SIGPROF, _too_slow)
    for file in files:
        faulthandler.dump_traceback_later(DEADLOCK, exit=True)
        signal.setitimer(signal.ITIMER_VIRTUAL, HANG)  # nothing handles it: the process dies
        signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS)
        try:
            said = complaints(Path(file))
        except Exception as error:  # noqa: BLE001 it must not raise, whatever it is
            import traceback

            said = ["".join(traceback.format_exception(error))]
        signal.setitimer(signal.ITIMER_PROF, 0)
        sys.stdout.write(json.dumps([file, said]) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
