"""Which pass waits for which others, through however many others?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping


class Order:
    """All passes that each one waits for and that wait for it, as the bits of integers: thousands of
    passes that wait for each other are millions of pairs."""

    def __init__(self, waits: Mapping[str, Iterable[str]]) -> None:
        self._bits = {path: 1 << index for index, path in enumerate(waits)}
        inputs = {path: [i for i in found if i in waits] for path, found in waits.items()}
        readers: dict[str, list[str]] = {path: [] for path in waits}
        for path, found in inputs.items():
            for one in found:
                readers[one].append(path)
        self._before, self._after = self._reached(inputs), self._reached(readers)

    def _reached(self, edges: Mapping[str, list[str]]) -> dict[str, int]:
        order, found = list(_leaves_first(edges)), dict.fromkeys(edges, 0)
        changed = True
        while changed:  # again only where passes wait for each other
            changed = False
            for path in order:
                reached = found[path]
                for one in edges[path]:
                    reached |= found[one] | self._bits[one]
                changed = changed or reached != found[path]
                found[path] = reached
        return found

    def bits(self, paths: Iterable[str]) -> int:
        found = 0
        for path in paths:
            found |= self._bits[path]
        return found

    def waits_for_itself(self, path: str) -> bool:
        return bool(self._before[path] & self._bits[path])

    def one_way(self, path: str) -> int:
        """Those of which it is certain which of the two comes first."""
        return self._before[path] ^ self._after[path]

    def unordered(self, path: str) -> int:
        """All but itself of which nothing says which of the two comes first."""
        return ~(self._before[path] | self._after[path] | self._bits[path])


def _leaves_first(edges: Mapping[str, list[str]]) -> Iterator[str]:
    begun: set[str] = set()
    for root in edges:
        if root in begun:
            continue
        begun.add(root)
        pending = [(root, iter(edges[root]))]
        while pending:
            path, further = pending[-1]
            for one in further:
                if one not in begun:
                    begun.add(one)
                    pending.append((one, iter(edges[one])))
                    break
            else:
                pending.pop()
                yield path
