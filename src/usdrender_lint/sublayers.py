"""Which layers stand below one, and does one of them keep USD waiting forever?"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from itertools import islice

from pxr import Sdf, Tf

from .crate import mentions
from .handed import bytes_at
from .opening import FOLDER, no_file
from .unopened import Unreadable

_SMALL, _SMALL_CRATE = 1_000_000, 100_000
"""Bytes of a layer in which all asset paths are found in no time."""
_ARCS = (b"references", b"payload")
_CROWD = 16
"""Files in one folder that are looked at as one."""


def sublayers_of(
    layer: Sdf.Layer,
    look_through: Callable[[Sdf.Layer], None],
    mention: Callable[[str, bytes], bool | None],
) -> tuple[list[Sdf.Layer], Unreadable | None]:
    """All layers below, to be held until the stage is open, which needs them, too; and a pipe or
    device that is brought in, for which USD would wait forever.

    `look_through` raises for a crate that lists what is not there: asked for the arcs of such a one,
    USD ends the process. `mention` tells whether the text of a layer holds a word.

    What lies behind references is not looked at: it is opened only where the render spec needs it.
    """
    held, known = [layer], {layer.identifier}
    for one in held:
        all_assets = _brought_in(one, look_through, mention)
        if not (all_assets or one.subLayerPaths):
            continue
        sublayers = {one.ComputeAbsolutePath(name) for name in one.subLayerPaths}
        new = sublayers.union(map(one.ComputeAbsolutePath, all_assets)) - known
        known |= new
        for file in sorted(new - (_plain_files(new) - sublayers)):
            try:
                what = no_file(os.stat(file).st_mode)
            except (OSError, ValueError):  # told where it is missed
                continue
            if what not in (None, FOLDER):
                return held, Unreadable(
                    file, "unreadable-file", f"{what}, not a file", one.realPath
                )
            if file in sublayers:
                with suppress(Tf.ErrorException):
                    if found := Sdf.Layer.FindOrOpen(file):
                        held.append(found)
    return held, None


def _plain_files(files: Iterable[str]) -> set[str]:
    """Those that are nothing else, as far as many of them stand in one folder: to list it takes less
    than to ask for each."""
    by_folder = Counter(file.rpartition("/")[0] for file in files)
    plain: set[str] = set()
    for folder, number in by_folder.items():
        if number >= _CROWD:
            with suppress(OSError, ValueError), os.scandir(folder) as entries:
                few = islice(entries, 4 * number)  # there may be a hundred times as many
                # Not as the entry spells its path, which is another way on Windows.
                plain.update(f"{folder}/{e.name}" for e in few if e.is_file(follow_symlinks=False))
    return plain


def _brought_in(
    layer: Sdf.Layer,
    look_through: Callable[[Sdf.Layer], None],
    mention: Callable[[str, bytes], bool | None],
) -> list[str]:
    """What a small layer names in its arcs."""
    file = bytes_at(layer.realPath)
    is_text = file.endswith(".usda")
    try:
        size = os.stat(file).st_size
    except OSError:
        return []
    if size >= (_SMALL if is_text else _SMALL_CRATE):
        return []
    if is_text:
        if mention(layer.realPath, b"@") is False:
            return []
    else:
        if mentions(file, _ARCS) is False:
            return []
        look_through(layer)
    return list(layer.GetCompositionAssetDependencies())
