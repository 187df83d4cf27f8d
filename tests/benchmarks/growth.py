"""Does what a run costs grow with what there is, or with its square?

    python tests/benchmarks/growth.py [--sizes 1000 2000 4000 8000] [--only TEXT] [--limit SECONDS]
    python tests/benchmarks/growth.py --write FOLDER ...

Each case has much of one thing. The CPU time of whole processes is shown without that of the same
case at a single one (importing USD, above all), and the exponent of the growth from the first size
to the last: 1 is linear, 2 a square. `--write` keeps the files, for a profiler.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path

TOOL = (sys.executable, "-m", "usdrender_lint", "--output-format", "concise")
META = '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/S"\n)\n'


def paths(found: Iterable[str]) -> str:
    return f"[{', '.join(f'<{path}>' for path in found)}]"


def prim(header: str, *body: str) -> str:
    return f"def {header}\n{{\n" + "".join(f"{line}\n" for line in body) + "}\n"


def settings(name: str = "S", products: str = "</Render/P>", *more: str) -> str:
    camera = "" if any("rel camera" in line for line in more) else "rel camera = </World/cam>"
    return prim(f'RenderSettings "{name}"', camera, f"rel products = {products}", *more)


def product(name: str = "P", ordered: str = "</Render/v>", out: str = "", *more: str) -> str:
    said = f'token productName = "/out/{out or name}.exr"'
    return prim(f'RenderProduct "{name}"', said, f"rel orderedVars = {ordered}", *more)


def var(name: str = "v", source: str = "") -> str:
    return prim(f'RenderVar "{name}"', f'string sourceName = "{source or name}"')


def render_pass(name: str, *more: str) -> str:
    return prim(f'RenderPass "{name}"', "rel renderSource = </Render/S>", *more)


ONE = settings() + product() + var()


def stage(render: str = ONE, world: str = "", outside: str = "") -> str:
    inside = prim('Camera "cam"') + world
    return META + prim('Scope "Render"', render) + prim('Xform "World"', inside) + outside


def each(count: int, text: Callable[[int], str]) -> str:
    return "".join(map(text, range(count)))


def nested(count: int, header: str, inside: str = "") -> str:
    return each(count, lambda i: f'def {header} "g{i}"\n{{\n') + inside + "}\n" * count


def below(count: int) -> str:
    return "".join(f"/g{i}" for i in range(count))


def collection(name: str, **rules: str) -> list[str]:
    return [f"rel collection:{name}:{rule} = {said}" for rule, said in rules.items()]


def includes(count: int, wanted: str = "/World/x", **more: str) -> str:
    said = paths(f"{wanted}{i}" for i in range(count))
    lists = collection("renderVisibility", includes=said, **more)
    world = each(count, lambda i: prim(f'Sphere "x{i}"'))
    return stage(ONE + render_pass("A", *lists), world)


def excluded(count: int) -> str:
    return includes(count, excludes=paths(f"/World/gone{i}" for i in range(count)))


def expression(count: int) -> str:
    said = " + ".join(f"/World/x{i}" for i in range(count))
    lists = [f'pathExpression collection:renderVisibility:membershipExpression = "{said}"']
    return stage(ONE + render_pass("A", *lists), each(count, lambda i: prim(f'Sphere "x{i}"')))


def collections(count: int, end: str = "/World") -> str:
    chain = each(
        count,
        lambda i: prim(
            f'"C{i}" (\n    apiSchemas = ["CollectionAPI:c"]\n)',
            *collection("c", includes=f"</C{i + 1}.collection:c>" if i < count - 1 else f"<{end}>"),
        ),
    )
    lists = collection("renderVisibility", includes="</C0.collection:c>")
    return stage(ONE + render_pass("A", *lists), outside=chain)


def passes(count: int) -> str:
    def one(i: int) -> str:
        return render_pass(f"A{i}", *[f"rel inputPasses = </Render/A{i - 1}>"][: i > 0])

    return stage(ONE + each(count, one))


def pass_cycle(count: int) -> str:
    def one(i: int) -> str:
        return render_pass(f"A{i}", f"rel inputPasses = </Render/A{(i + 1) % count}>")

    return stage(ONE + each(count, one))


def dense_passes(count: int) -> str:
    """As many lines between passes as `count`, times two."""

    def one(i: int) -> str:
        before = paths(f"/Render/A{j}" for j in range(i))
        return render_pass(f"A{i}", f"rel inputPasses = {before}")

    return stage(ONE + each(2 * math.isqrt(count), one))


def products(count: int, **how: str) -> str:
    listed = settings("S", paths(f"/Render/P{i}" for i in range(count)))
    return stage(listed + each(count, lambda i: product(f"P{i}", **how)) + var())


def product_cameras(count: int) -> str:
    listed = settings("S", paths(f"/Render/P{i}" for i in range(count)))
    made = each(count, lambda i: product(f"P{i}", "</Render/v>", "", f"rel camera = </World/c{i}>"))
    return stage(listed + made + var(), each(count, lambda i: prim(f'Camera "c{i}"')))


def hub(count: int) -> str:
    """Products that all take their vars from one place."""
    listed = settings("S", paths(f"/Render/P{i}" for i in range(count)))
    all_vars = paths(f"/Render/v{i}" for i in range(50))
    made = each(count, lambda i: product(f"P{i}", "</Render/Hub.f>"))
    shared = prim('Scope "Hub"', f"rel f = {all_vars}") + each(50, lambda i: var(f"v{i}"))
    return stage(listed + made + shared)


def forwarding(count: int, leaves: bool = False) -> str:
    def one(i: int) -> str:
        leaf = f"</Render/P{i}>, " if leaves else ""
        return prim(f'Scope "H{i}"', f"rel f = [{leaf}</Render/H{i + 1}.f>]")

    end = prim(f'Scope "H{count}"', "rel f = </Render/P0>")
    made = each(count if leaves else 1, lambda i: product(f"P{i}"))
    return stage(settings("S", "</Render/H0.f>") + each(count, one) + end + made + var())


def hubs(count: int) -> str:
    return forwarding(count, leaves=True)


def camera_chain(count: int) -> str:
    chain = each(count, lambda i: prim(f'Scope "W{i}"', f"rel f = </W{i + 1}.f>"))
    end = prim(f'Scope "W{count}"', "rel f = </World/cam>")
    first = settings("S", "</Render/P>", "rel camera = </W0.f>")
    return stage(first + product() + var(), outside=chain + end)


def missing_products(count: int) -> str:
    listed = settings("S", paths(f"/Render/X{i}" for i in range(count)))
    return stage(listed + each(count, lambda i: product(f"P{i}")) + var())


def missing_vars(count: int) -> str:
    listed = product("P", paths(f"/Render/q{i}" for i in range(count)))
    return stage(settings() + listed + each(count, lambda i: var(f"v{i}")))


def missing_layers(count: int) -> str:
    def one(name: str) -> str:
        return each(count, lambda i: prim(f'"{name}{i}" (references = @nope{i}.usda@)'))

    return stage(ONE + one("N"), outside=one("M"))


def vars_of_one(count: int, source: str = "", data_type: str = "") -> str:
    listed = product("P", paths(f"/Render/v{i}" for i in range(count)))
    more = f'token dataType = "{data_type}"' if data_type else ""
    made = each(
        count,
        lambda i: prim(f'RenderVar "v{i}"', f'string sourceName = "{source or f"v{i}"}"', more),
    )
    return stage(settings() + listed + made)


def suppressed(count: int) -> str:
    def one(i: int) -> str:
        return var(f"v{i}").replace("\n", "  # usdrender-lint: ignore[orphan-var]\n", 1)

    return stage(ONE + each(count, one))


def idle_comments(count: int) -> str:
    return stage(ONE + "# usdrender-lint: ignore[orphan-var]\n" * count)


def variant_sets(count: int) -> str:
    chosen = '(\n    variants = {\n        string q = "z"\n    }\n    variantSets = "q"\n)'
    said = 'variantSet "q" = {\n"a" {\n}\n}'
    return stage(ONE + each(count, lambda i: prim(f'RenderVar "v{i}" {chosen}', said)))


def strangers(count: int) -> str:
    said = each(count, lambda i: f"int bad{i} = 1\n")
    return stage(settings("S", "</Render/P>", said) + product() + var())


def misspelt(count: int) -> str:
    return stage(
        settings(
            "S",
            "</Render/P>",
            each(count, lambda i: f'uniform token materialBindingPurpose{i} = "a"\n'),
        )
        + product()
        + var()
    )


def samples(count: int) -> str:
    said = ", ".join(f"{i}: ({i + 1}, 1080)" for i in range(count))
    return stage(
        settings("S", "</Render/P>", f"int2 resolution.timeSamples = {{{said}}}")
        + product()
        + var()
    )


def path_elements(count: int) -> str:
    said = "lpe:C" + "<RD>" * count + ".*L"
    made = prim(
        'RenderVar "v"', f'string sourceName = "{said}"', 'uniform token sourceType = "lpe"'
    )
    return stage(settings() + product() + made)


def deep_camera(count: int) -> str:
    listed = settings("S", "</Render/P>", f"rel camera = <{below(count)}/cam>")
    return stage(listed + product() + var(), outside=nested(count, "Xform", prim('Camera "cam"')))


CASES: dict[str, Callable[[int], str]] = {
    "nested groups": lambda n: stage(ONE + nested(n, "Scope", var("deep"))),
    "nested groups, empty": lambda n: stage(ONE + nested(n, "Scope")),
    "groups side by side": lambda n: stage(ONE + each(n, lambda i: prim(f'Scope "g{i}"'))),
    "nothing but nested groups": lambda n: META + prim('Scope "Render"', nested(n, "Scope")),
    "nested scene": lambda n: stage(outside=nested(n, "Xform")),
    "camera far below": deep_camera,
    "products": products,
    "products of one name": lambda n: products(n, out="a"),
    "products with their cameras": product_cameras,
    "products x hub of 50 vars": hub,
    "vars": vars_of_one,
    "vars of one name": lambda n: vars_of_one(n, "Ci"),
    "vars of unknown type": lambda n: vars_of_one(n, data_type="colour3f"),
    "vars that nobody lists": lambda n: stage(ONE + each(n, lambda i: var(f"w{i}"))),
    "vars outside the scope": lambda n: stage(outside=each(n, lambda i: var(f"w{i}"))),
    "inactive vars": lambda n: stage(
        ONE + each(n, lambda i: prim(f'RenderVar "w{i}" (active = false)'))
    ),
    "settings": lambda n: stage(ONE + each(n, lambda i: settings(f"S{i}"))),
    "passes": passes,
    "passes without settings": lambda n: stage(ONE + each(n, lambda i: prim(f'RenderPass "A{i}"'))),
    "passes in a circle": pass_cycle,
    "passes of all before": dense_passes,
    "forwarding": forwarding,
    "forwarding with leaves": hubs,
    "forwarding to the camera": camera_chain,
    "missing products": missing_products,
    "missing vars": missing_vars,
    "missing layers": missing_layers,
    "included prims": includes,
    "included prims, missing": lambda n: includes(n, "/World/gone"),
    "excluded prims, missing": excluded,
    "paths in an expression": expression,
    "chain of collections": collections,
    "chain of collections, missing": lambda n: collections(n, "/World/gone"),
    "suppressions": suppressed,
    "suppressions that hide nothing": idle_comments,
    "variant sets": variant_sets,
    "unknown properties": strangers,
    "misspelt properties": misspelt,
    "time samples": samples,
    "elements of a light path": path_elements,
}


def cpu(file: Path, limit: float) -> float | None:
    """Seconds of user and system; None where the limit is passed."""
    said = subprocess.DEVNULL
    process = subprocess.Popen([*TOOL, str(file)], stdout=said, stderr=said, cwd=file.parent)
    try:
        from threading import Timer

        timer = Timer(limit, process.kill)
        timer.start()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    finally:
        timer.cancel()
    if process.returncode not in (0, 1, 2):
        return None
    return used.ru_utime + used.ru_stime


def row(name: str, sizes: list[int], folder: Path, limit: float) -> str:
    def cost(size: int) -> float | None:
        file = folder / f"{name.replace(' ', '_').replace(',', '')}_{size}.usda"
        file.write_text(CASES[name](size), "utf-8")
        return cpu(file, limit)

    least = cost(1) or 0.0
    costs: list[float | None] = []
    for size in sizes:
        found = None if None in costs else cost(size)
        costs.append(None if found is None else max(found - least, 0.01))
    cells = [f"{c:.2f}" if c is not None else f"> {limit:g}" for c in costs]
    known = [(n, c) for n, c in zip(sizes, costs, strict=True) if c is not None]
    exponent = ""
    if len(known) > 1:
        (first, low), (last, high) = known[0], known[-1]
        exponent = f"{math.log(high / low) / math.log(last / first):.1f}"
    return "| " + " | ".join((name, *cells, exponent)) + " |"


def main() -> int:
    parser = argparse.ArgumentParser(description="Measure how the cost grows with what there is.")
    parser.add_argument("--sizes", type=int, nargs="+", default=[1000, 2000, 4000, 8000])
    parser.add_argument(
        "--only", default="", metavar="TEXT", help="only cases with this in the name"
    )
    parser.add_argument("--limit", type=float, default=60.0, help="seconds for one run")
    parser.add_argument("--write", type=Path, metavar="FOLDER", help="keep the files there")
    arguments = parser.parse_args()
    print("| case | " + " | ".join(f"{n:,}" for n in arguments.sizes) + " | exponent |")
    print("|---" * (len(arguments.sizes) + 2) + "|", flush=True)
    with tempfile.TemporaryDirectory() as made:
        folder = arguments.write or Path(made)
        folder.mkdir(parents=True, exist_ok=True)
        for name in CASES:
            if arguments.only in name:
                print(row(name, arguments.sizes, folder, arguments.limit), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
