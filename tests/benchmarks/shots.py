"""Which stages are measured? This writes them.

    python tests/benchmarks/shots.py OUT [--scale FACTOR]

Nine cases in the folder OUT, and `stages.json`, which names their roots. At full
scale they take about 85 MB and half a minute; `--scale 0.01` makes small ones.
`pxr` is only imported where a layer is built.
"""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

MANIFEST = "stages.json"
PRIMS_PER_ASSET = 500
PRIMS_PER_GROUP = 1000
POINTS_PER_MESH = 120
MEGABYTE = 1_000_000

_HEADER = """#usda 1.0
(
    defaultPrim = "World"
    renderSettingsPrimPath = "/Render/final"
    metersPerUnit = 0.01
    upAxis = "Y"
)
"""

_CAMERA = """    def Camera "cam"
    {
        float2 clippingRange = (1, 100000)
        float focalLength = 35
        double3 xformOp:translate = (0, 150, 500)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
"""

_WORLD = f"""
def Xform "World"
{{
{_CAMERA}    def Sphere "ball"
    {{
    }}
    def DistantLight "sun"
    {{
    }}
}}
"""


def render_scope(camera: str = "/World/cam", name: str = "shot") -> str:
    """A whole render spec as text: one settings, two products, four vars."""
    return f"""
def Scope "Render"
{{
    def RenderSettings "final"
    {{
        rel camera = <{camera}>
        rel products = [
            </Render/Products/beauty>,
            </Render/Products/data>,
        ]
        uniform int2 resolution = (1920, 1080)
        uniform token[] includedPurposes = ["default", "render"]
        uniform token[] materialBindingPurposes = ["full", ""]
    }}
    def Scope "Products"
    {{
        def RenderProduct "beauty"
        {{
            token productName = "/out/{name}/beauty.exr"
            rel orderedVars = [
                </Render/Vars/color>,
                </Render/Vars/alpha>,
                </Render/Vars/diffuse>,
            ]
        }}
        def RenderProduct "data"
        {{
            token productName = "/out/{name}/data.exr"
            rel orderedVars = </Render/Vars/depth>
        }}
    }}
    def Scope "Vars"
    {{
        def RenderVar "color"
        {{
            uniform token dataType = "color3f"
            uniform string sourceName = "Ci"
        }}
        def RenderVar "alpha"
        {{
            uniform token dataType = "float"
            uniform string sourceName = "a"
        }}
        def RenderVar "diffuse"
        {{
            uniform token dataType = "color3f"
            uniform string sourceName = "C<RD>[<L.>O]"
            uniform token sourceType = "lpe"
        }}
        def RenderVar "depth"
        {{
            uniform token dataType = "float"
            uniform string sourceName = "z"
        }}
    }}
}}
"""


def tiny(out: Path) -> Path:
    """One small file, nothing wrong: what a run costs at least."""
    path = out / "tiny.usda"
    path.write_text(_HEADER + render_scope() + _WORLD)
    return path


def wrong(out: Path) -> Path:
    """The same with two findings: what it costs more to find and show a place in the text."""
    path = out / "wrong.usda"
    scope = render_scope(camera="/World/cam_v2").replace(
        '"/out/shot/data.exr"', '"/out/shot/beauty.exr"'
    )
    path.write_text(_HEADER + scope + _WORLD)
    return path


def layered(out: Path, assets: int, prims: int = PRIMS_PER_ASSET) -> Path:
    """A shot: render, camera and layout sublayered, every asset a crate of its own behind a reference."""
    shot = out / f"layered_{assets}"
    folder = shot / "assets"
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"asset_{n:04}" for n in range(assets)]
    first = folder / "original.usdc"
    _asset(first, prims)
    for name in names:
        shutil.copyfile(first, folder / f"{name}.usdc")
    first.unlink()

    root = shot / "shot.usda"
    layers = ("render", "camera", "layout")
    listed = ",\n".join(f"        @./{layer}.usda@" for layer in layers)
    root.write_text(_HEADER.replace("\n)\n", f"\n    subLayers = [\n{listed}\n    ]\n)\n"))
    (shot / "render.usda").write_text("#usda 1.0\n" + render_scope(name=shot.name))
    (shot / "camera.usda").write_text(f'#usda 1.0\n\nover "World"\n{{\n{_CAMERA}}}\n')
    with (shot / "layout.usda").open("w") as layout:
        layout.write('#usda 1.0\n\ndef Xform "World"\n{\n')
        for name in names:
            layout.write(f'    def "{name}" (\n')
            layout.write(
                f"        prepend references = @./assets/{name}.usdc@\n    )\n    {{\n    }}\n"
            )
        layout.write("}\n")
    return root


def flat(out: Path, prims: int) -> Path:
    """One crate that holds everything: that many prims, no two of one name, and /Render last."""
    from pxr import Sdf

    path = out / "flat.usdc"
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    layer.ImportFromString(_HEADER + _WORLD + render_scope())
    with Sdf.ChangeBlock():
        world = layer.GetPrimAtPath("/World")
        made = 0
        while made < prims:
            group = _prim(world, f"group_{made // PRIMS_PER_GROUP}", "Xform")
            inside = min(PRIMS_PER_GROUP, prims - made)
            for n in range(made + 1, made + inside):
                _prim(group, f"prim_{n}", "Sphere")
            made += inside
    layer.Export(str(path))
    return path


def text(out: Path, megabytes: float) -> Path:
    """One large text layer with two findings at its end, after all the geometry."""
    path = out / "text.usda"
    wrong = render_scope(camera="/World/cam_v2").replace(
        '"/out/shot/data.exr"', '"/out/shot/beauty.exr"'
    )
    with path.open("w") as file:
        file.write(_HEADER + _WORLD.rstrip().removesuffix("}"))
        size = 0
        for mesh in _meshes():
            if size >= megabytes * MEGABYTE:
                break
            size += file.write(mesh)
        file.write("}\n" + wrong)
    return path


def many(out: Path, stages: int) -> Path:
    """A folder of small stages; every tenth targets a camera that is not there."""
    folder = out / "many"
    folder.mkdir(exist_ok=True)
    for n in range(stages):
        camera = "/World/cam" if n % 10 else "/World/no_cam"
        scope = render_scope(camera, name=f"shot_{n:04}")
        (folder / f"shot_{n:04}.usda").write_text(_HEADER + scope + _WORLD)
    return folder


def in_layers(out: Path, shots: int) -> Path:
    """Shots of ten layers each, with a configuration that names their roots."""
    folder = out / "in_layers"
    names = ("render", "camera", "layout", *(f"extra_{n}" for n in range(6)))
    listed = ", ".join(f"@./layers/{name}.usda@" for name in names)
    for n in range(shots):
        layers = folder / f"sh{n:03}" / "layers"
        layers.mkdir(parents=True, exist_ok=True)
        shot = _HEADER.replace("\n)\n", f"\n    subLayers = [{listed}]\n)\n")
        (layers.parent / "shot.usda").write_text(shot)
        for name in names:
            (layers / f"{name}.usda").write_text('#usda 1.0\n\nover "World"\n{\n}\n')
        (layers / "render.usda").write_text("#usda 1.0\n" + render_scope(name=f"sh{n:03}"))
        (layers / "camera.usda").write_text(f'#usda 1.0\n\ndef "World"\n{{\n{_CAMERA}}}\n')
    (folder / "usdrender-lint.toml").write_text('roots = ["*/shot.usda"]\n')
    return folder


def generate(out: Path, scale: float = 1.0) -> dict[str, Path]:
    """Every case, scaled; the numbers in the names are those of full scale."""
    cases: dict[str, Callable[[], Path]] = {
        "tiny": lambda: tiny(out),
        "tiny, with findings": lambda: wrong(out),
        "layered, 20 crates": lambda: layered(out, _scaled(20, scale)),
        "layered, 2,000 crates": lambda: layered(out, _scaled(2_000, scale, least=2)),
        "flat, 1,000,000 prims": lambda: flat(out, _scaled(1_000_000, scale)),
        "text, 57 MB": lambda: text(out, 57 * scale),
        "folder of 1,000": lambda: many(out, _scaled(1_000, scale)),
        "50 shots in layers": lambda: in_layers(out, _scaled(50, scale)),
        "one layer of 50 shots": lambda: (
            in_layers(out, _scaled(50, scale)) / "sh000/layers/camera.usda"
        ),
    }
    out.mkdir(parents=True, exist_ok=True)
    made = {name: build() for name, build in cases.items()}
    relative = {name: path.relative_to(out).as_posix() for name, path in made.items()}
    manifest = {"scale": scale, "stages": relative}
    (out / MANIFEST).write_text(json.dumps(manifest, indent=1) + "\n")
    return made


def _scaled(number: int, scale: float, least: int = 1) -> int:
    return max(least, round(number * scale))


def _asset(path: Path, prims: int) -> None:
    from pxr import Sdf

    layer = Sdf.Layer.CreateAnonymous(".usdc")
    with Sdf.ChangeBlock():
        root = _prim(layer, "asset", "Xform")
        layer.defaultPrim = "asset"
        for n in range(1, prims):
            _prim(root, f"part_{n}", "Sphere")
    layer.Export(str(path))


def _prim(parent: Any, name: str, type_name: str) -> Any:
    from pxr import Sdf

    return Sdf.PrimSpec(parent, name, Sdf.SpecifierDef, type_name)


def _meshes() -> Iterator[str]:
    """Meshes without end, some 5 kB of text each, no two alike."""
    n = 0
    while True:
        points = ", ".join(
            f"({(n + p) % 977 / 7:.6g}, {(n * p) % 499 / 3:.6g}, {p / 11:.6g})"
            for p in range(POINTS_PER_MESH)
        )
        indices = ", ".join(str(p) for p in range(POINTS_PER_MESH))
        counts = ", ".join("3" for _ in range(POINTS_PER_MESH // 3))
        yield f"""    def Mesh "mesh_{n}"
    {{
        int[] faceVertexCounts = [{counts}]
        int[] faceVertexIndices = [{indices}]
        point3f[] points = [{points}]
    }}
"""
        n += 1


def main() -> None:
    parser = argparse.ArgumentParser(description="Write the stages that bench.py measures.")
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--scale", type=float, default=1.0, help="1 is full size (default)")
    arguments = parser.parse_args()
    for name, path in generate(arguments.out, arguments.scale).items():
        print(f"{name}: {path}")


if __name__ == "__main__":
    main()
