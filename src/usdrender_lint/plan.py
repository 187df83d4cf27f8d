"""Which files are linted, each by which configuration, and what hides what is known of them?"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .config import Configuration
from .config.find import Configurations
from .context import stages_of
from .discover import STDIN, Found, Shard, Shown, discover, root_of
from .job import Asked, Config
from .patterns import Patterns
from .records import dataclass
from .results import Problem
from .wanted import Options, baseline, wanted


@dataclass(frozen=True, slots=True)
class Sought:
    """What the command line says about files."""

    paths: Sequence[str]
    exclude: Patterns | None = None
    """Beside what configurations exclude."""
    gitignored: bool = False
    """Find what git ignores, too."""
    shard: Shard | None = None
    """Lint only the part of the files that falls to this run."""
    nameless: str = ""
    """The path among them that stands for standard input, where nobody named a file."""


@dataclass(frozen=True, slots=True)
class KnownIn:
    """A baseline that some of the files have."""

    file: Path
    start: str
    """The folder from which it tells of layers."""
    roots: tuple[str, ...]
    """The files, as shown."""


@dataclass(frozen=True, slots=True)
class Plan:
    asked: tuple[Asked, ...]
    problems: tuple[Problem, ...]
    excluded: tuple[str, ...]
    """Paths that were named, and are excluded; as shown."""
    shard: Shard | None
    shown: Shown
    otherwise: Config
    """What is asked for where there is no file."""
    baselines: tuple[KnownIn, ...]

    @property
    def why_nothing(self) -> str | None:
        """Why no file is linted, where that is as it should be."""
        if self.asked or self.problems:
            return None
        if self.shard and not self.excluded:
            return f"shard {self.shard.number} of {self.shard.of} has none"
        return "all are excluded"


def seek(sought: Sought, configurations: Configurations) -> tuple[Found, Shown]:
    """`ConfigError` for a configuration that cannot be used."""
    shown = Shown(root=root_of(sought.paths, configurations))
    if sought.nameless:
        shown.call(sought.nameless, STDIN)
    found = discover(
        sought.paths, shown, configurations, sought.exclude, gitignored=sought.gitignored
    )
    if sought.shard:
        # A layer is judged where its stage is.
        stages = stages_of(found.files)
        ours = [f for f in found.files if stages.get(f.shown, f.shown) in sought.shard]
        # A folder that is excluded as a whole says nothing of a shard that others have files for.
        excluded = [] if found.files else found.excluded
        found = Found(ours, found.problems, excluded)
    return found, shown


def plan(sought: Sought, options: Options, configurations: Configurations) -> Plan:
    """`ConfigError` or `WantedError` for what cannot be had."""
    found, shown = seek(sought, configurations)
    configs: dict[Configuration, Config] = {}

    def config_of(configuration: Configuration) -> Config:
        if configuration not in configs:
            configs[configuration] = wanted(configuration, options)
        return configs[configuration]

    asked = []
    known: dict[tuple[Path, str], list[str]] = {}
    for file in found.files:
        configuration = configurations.of_file(file.file)
        asked.append((file, config_of(configuration)))
        if options.baseline:
            known.setdefault((options.baseline, str(shown.root)), []).append(file.shown)
        elif in_configuration := baseline(configuration):
            folder = str(in_configuration.parent)
            start = configurations.root(folder) or folder
            known.setdefault((in_configuration, start), []).append(file.shown)
    if options.baseline and not known:
        known[options.baseline, str(shown.root)] = []
    return Plan(
        tuple(asked),
        tuple(found.problems),
        tuple(found.excluded),
        sought.shard,
        shown,
        asked[0][1] if asked else config_of(configurations.of(str(Path.cwd()))),
        tuple(KnownIn(file, start, tuple(roots)) for (file, start), roots in known.items()),
    )
