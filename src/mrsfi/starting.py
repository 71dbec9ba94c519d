"""Make a new project: a folder ready for git, with a mission that flies.

Begin with ``start``, which fills the folder from ``template``, completely or not at all.
``node_table`` writes a first table ``[node]`` from the topics of a rosbridge server. It maps only
topics of types that robots usually have; a person has to check the table.
"""

import json
import re
import shutil
import subprocess
from collections.abc import Mapping
from contextlib import closing
from hashlib import sha256
from importlib.metadata import distributions
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from m2t.classes import class_files, write_classes
from m2t.generate import generate
from m2t.metamodels import load_metamodels, metamodel_folder
from m2t.models.importing import import_published
from mrsfi.folders import find_mission
from mrsfi_bridge.settings import full_name
from mrsfi_runtime.cosimulation.bus_lockstep import Completion
from mrsfi_runtime.errors import TransportTimeout, UsageError
from mrsfi_runtime.files import whole_folder
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.fault_types import plain_name
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.project_file import SETTINGS, installed_version
from mrsfi_runtime.transport.rosbridge import RosbridgeTransport
from mrsfi_runtime.transport.topics import TOPICS

_PATIENCE_S = 10.0
_POSE = {"position.x": "x", "position.y": "y", "orientation.z": "qz", "orientation.w": "qw"}
_TWIST = {"linear.x": "speed", "angular.z": "turn"}


def _below(path: str, fields: Mapping[str, str]) -> dict[str, str]:
    return {f"{path}.{field}": of for field, of in fields.items()}


_TELLS = {
    "nav_msgs/Odometry": {**_below("pose.pose", _POSE), "twist.twist.linear.x": "speed"},
    "geometry_msgs/PoseStamped": _below("pose", _POSE),
    "sensor_msgs/BatteryState": {"percentage": "energy"},
}
_OBEYS = {
    "geometry_msgs/Twist": _TWIST,
    "geometry_msgs/TwistStamped": _below("twist", _TWIST),
}
"""Fields of the messages that robots usually publish or subscribe to, by message type."""


def topics_of(url: str) -> dict[str, str]:
    """Return the topics of a rosbridge server and their types, as it spells them."""
    completion = Completion()
    with closing(RosbridgeTransport(url)) as transport:
        transport.call(TOPICS, {}, completion.end)
        late = TransportTimeout(f"{url}: /rosapi/topics did not answer; start rosapi there")
        reply = completion.wait(lambda silence: late if silence > _PATIENCE_S else None)
    values = reply.values
    return dict(zip(values.get("topics", ()), values.get("types", ()), strict=False))


def node_table(topics: Mapping[str, str], mission: Mission) -> str:
    """Return the text of ``[node]`` for the topics of a running system, for a person to check.

    Robots of the model are matched in order with names in alphabetical order. Topics of other types
    follow as comments. If there are no others, it is a ``UsageError``.
    """
    known_types = {*_TELLS, *_OBEYS}
    of_robots = {name: kind for name, kind in topics.items() if full_name(kind) in known_types}
    if not of_robots:
        raise UsageError(
            f"--node: found {', '.join(sorted(topics)) or 'no topic'}; expected a topic of one of "
            f"{', '.join((*_TELLS, *_OBEYS))}: start the robots first"
        )
    found = sorted({_parted(name)[0] for name in of_robots} - {""})
    ids = [plain_name(robot.id) for robot in mission.robots]
    names = dict(zip(ids, found, strict=False))
    lines = ["[node]"]
    if names and names != {each: each for each in names}:
        lines.append(f"names = {_inline(names)}")
    energy = sum(battery.total_energy for battery in mission.robots[0].batteries)
    for role, known in (("tells", _TELLS), ("obeys", _OBEYS)):
        rules = {
            _rule(name, kind, ids[0], energy)
            for name, kind in of_robots.items()
            if full_name(kind) in known
        }
        for topic, kind, fields in sorted(rules):
            lines += ["", f"[[node.{role}]]", f'topic = "{topic}"', f'type = "{kind}"', fields]
    others = sorted(f"# {name} {kind}" for name, kind in topics.items() if name not in of_robots)
    return "\n".join([*lines, "", "# Topics that are not mapped:", *others, ""])


def _parted(topic: str) -> tuple[str, str]:
    """Return the robot's name in a topic, if any, and the rest of the topic."""
    robot, slash, rest = topic.removeprefix("/").partition("/")
    return (robot, f"/{rest}") if slash else ("", topic)


def _rule(topic: str, kind: str, first: str, energy: float) -> tuple[str, str, str]:
    robot, rest = _parted(topic)
    kind = full_name(kind)
    fields: dict[str, Any] = {**_TELLS.get(kind, {}), **_OBEYS.get(kind, {})}
    if not robot:
        fields = {field: f"{first}.{of}" for field, of in fields.items()}
    if "percentage" in fields:
        fields["percentage"] = {"of": fields["percentage"], "scale": 1.0 / energy}
    return (f"/{{robot}}{rest}" if robot else topic), kind, f"fields = {_inline(fields)}"


def _inline(values: Mapping[str, Any]) -> str:
    entries = []
    for name, value in values.items():
        text = _inline(value) if isinstance(value, Mapping) else repr(value).replace("'", '"')
        entries.append(f'"{name}" = {text}' if "." in name else f"{name} = {text}")
    return f"{{ {', '.join(entries)} }}"


_TEMPLATE = Path(__file__).parent / "template"
_PLACES = {
    "Makefile": "Makefile",
    "README.md": "README.md",
    "github.yml": ".github/workflows/mrsfi.yml",
    "gitignore": ".gitignore",
    "gitlab.yml": ".gitlab-ci.yml",
    "mrsfi.toml": "mrsfi.toml",
}
_SHARED_URL = re.compile(r"https?://[\w.:/~+-]+|(ssh|file)://[\w.@:/~+-]+", re.ASCII)


def start(
    name: str,
    source: str | None = None,
    published: Path | None = None,
    node: str | None = None,
    install: str = "wheel",
) -> Path:
    """Make the folder of a new project with a mission of its name, completely or not at all.

    The mission is a small one, or a copy of ``source``, or a ``published`` model of the paper's
    prototype. If ``node`` is the URL of a rosbridge server, ``mrsfi.toml`` maps its topics. Build
    servers install mrsfi from ``wheel_of`` the project, the package ``index`` or ``git``.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name):
        raise UsageError(
            f"found the name '{name}'; expected a letter, then letters, digits and _, because it "
            "becomes part of names in Python"
        )
    folder = Path(name)
    begun_from = None if source is None else find_mission(source).models.resolve()
    requirement = _requirement(install)
    with whole_folder(folder) as new:
        if folder.exists():
            raise UsageError(f"{folder}: exists; expected a new name")
        _fill(new, name, requirement, begun_from, published)
        if install == "wheel":  # this mrsfi was installed from, if it is unchanged
            origin, wheel = _origin(), wheel_of(new)
            digest = origin.get("archive_info", {}).get("hashes", {}).get("sha256")
            path = Path(unquote(urlsplit(origin.get("url", "")).path))
            wheel.parent.mkdir()
            if digest and path.is_file() and sha256(path.read_bytes()).hexdigest() == digest:
                shutil.copy(path, wheel)
        if node is not None:
            mission = load_code(new / "generated" / name).mission
            with (new / SETTINGS).open("a", encoding="utf-8", newline="\n") as settings:
                settings.write(f"\n{node_table(topics_of(node), mission)}")
    return folder


def wheel_of(folder: Path) -> Path:
    """Return the path of the wheel of mrsfi in a project, for its build servers."""
    return folder / "vendor" / f"mrsfi-{installed_version('mrsfi')}-py3-none-any.whl"


def _requirement(install: str) -> str:
    """Return the requirement that build servers install with pip."""
    if install == "wheel":
        return f"{wheel_of(Path()).as_posix()}[fast]"
    if install == "index":
        return f"mrsfi[fast]=={installed_version('mrsfi')}"
    origin = _origin()
    url, commit = origin.get("url", ""), origin.get("vcs_info", {}).get("commit_id")
    if "dir_info" in origin:
        asked = "git remote get-url origin && git rev-parse HEAD"
        clone = unquote(urlsplit(url).path)
        done = subprocess.run(asked, shell=True, cwd=clone, capture_output=True, check=False)
        url, commit = done.stdout.decode().split() if done.returncode == 0 else ("", "")
        url = re.sub(r"^(?=/)", "file://", re.sub(r"^([\w.-]+@[\w.-]+):", r"ssh://\1/", url))
    if not (commit and _SHARED_URL.fullmatch(url)):
        raise UsageError(
            "--install git: found no repository of this mrsfi; expected that pip installed it from "
            "git, or from a clone whose origin is a URL without a password; use --install wheel "
            "or index"
        )
    return f"mrsfi[fast] @ git+{url}@{commit}"


def _origin() -> dict[str, Any]:
    """Return pip's note on the source of mrsfi, ``direct_url.json``; empty for an index."""
    texts = (each.read_text("direct_url.json") for each in distributions(name="mrsfi"))
    return json.loads(next(texts, None) or "{}")  # type: ignore[no-any-return]


def _fill(
    folder: Path, mission: str, requirement: str, source: Path | None, published: Path | None
) -> None:
    models = folder / "models" / mission
    for name, place in _PLACES.items():
        _write(_TEMPLATE / name, folder / place, mission, requirement)
    _copy(metamodel_folder(), folder / "metamodels", "*")
    if published is not None:
        import_published(published, models)
    elif source is not None:
        _copy(source, models, "*.xmi", "*.toml")
    else:
        for name in ("build.py", "case_a.toml", "faults.xmi", "mission.xmi"):
            _write(_TEMPLATE / "mission" / name, models / name, mission)
    generate(models, folder / "generated" / mission)
    write_classes(folder / "generated" / "metamodel", class_files(load_metamodels().packages))


def _copy(source: Path, target: Path, *patterns: str) -> None:
    for path in sorted(path for pattern in patterns for path in source.rglob(pattern)):
        if path.is_file():
            copy = target / path.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, copy)


def _write(template: Path, place: Path, name: str, requirement: str = "") -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    text = template.read_text(encoding="utf-8").replace("@name@", name)
    text = text.replace("@requirement@", requirement)
    place.write_text(text, encoding="utf-8", newline="\n")
