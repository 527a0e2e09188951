# SPDX-License-Identifier: Apache-2.0
"""Who includes, calls and imports whom: graphs of the sources, and the rules of CONTRIBUTING.md."""

import ast
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

CODE = ("*.c", "*.h", "*.cpp", "*.hpp")


def circle(graph: dict) -> list:
    """The nodes of one circle of a graph of sets, or []."""
    try:
        tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        return list(error.args[1])
    return []


# ---- C and C++


def code_files(folder: Path) -> list:
    return sorted(path for pattern in CODE for path in folder.rglob(pattern))


def without_comments(text: str) -> str:
    return re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.DOTALL)


def included(path: Path) -> list:
    """(quoted, name) of each #include of a file."""
    found = re.findall(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', without_comments(path.read_text()), re.MULTILINE)
    return [(mark == '"', name) for mark, name in found]


def include_graph(folder: Path, roots: tuple = ()) -> dict:
    """file -> the files of the same folder that it includes, found beside it or below one of the roots."""
    files = set(code_files(folder))
    graph = {}
    for path in files:
        candidates = ((base / name).resolve() for _, name in included(path) for base in (path.parent, *roots))
        graph[path] = {other for other in candidates if other in files}
    return graph


def call_graph(source: Path) -> dict:
    """file -> the files whose external functions, all named bn_, it calls."""
    texts = {path: without_comments(path.read_text()) for path in source.rglob("*.c")}
    home = {}
    for path, text in texts.items():
        for name in re.findall(r"^(?!static\b)(?:[a-z]\w*[\s*]+)+(bn_\w+)\([^;{}]*\)\s*\{", text, re.MULTILINE):
            home.setdefault(name, set()).add(path)
    graph = {}
    for path, text in texts.items():
        called = set(re.findall(r"\b(bn_\w+)\s*\(", text))
        graph[path] = set().union(*(home.get(name, set()) for name in called)) - {path}
    return graph


def folders_of(contributing: str) -> dict:
    """folder -> the folders it may see, itself among them, by the table in CONTRIBUTING.md."""
    table = contributing[contributing.index("| source folder |"):].split("\n\n")[0]
    folders = {}
    for row in table.splitlines()[2:]:
        name, _, sees = (cell.strip() for cell in row.strip("|").split("|"))
        folders[name.strip("`")] = {name.strip("`"), *re.findall(r"`(\w+)`", sees)}
    return folders


def folder_violations(source: Path, folders: dict) -> list:
    found = []
    for path in code_files(source):
        folder = path.relative_to(source).parts[0]
        if folder not in folders:
            found.append(f"{path.name} is in no folder of the table in CONTRIBUTING.md")
            continue
        for quoted, name in included(path):
            if quoted and name.split("/")[0] not in folders[folder]:
                found.append(f"{folder}/{path.name} includes {name}")
    return found


def keepers_violations(source: Path, keepers: dict) -> list:
    """keepers: pattern -> the one file of libbn/src that may contain it."""
    return [
        f"{path.relative_to(source)} has {word.group()}, which belongs in {keeper}"
        for pattern, keeper in keepers.items()
        for path in code_files(source)
        if path.relative_to(source).as_posix() != keeper
        for word in [re.search(pattern, without_comments(path.read_text()))]
        if word
    ]


def insiders(root: Path, folders: tuple) -> set:
    """Files of folders outside libbn/src that include a header of libbn/src."""
    source = (root / "libbn" / "src").resolve()
    found = set()
    for folder in folders:
        for path in code_files(root / folder):
            for _, name in included(path):
                beside, below = (path.parent / name).resolve(), (source / name).resolve()
                if source in beside.parents or (not beside.exists() and source in below.parents and below.exists()):
                    found.add(path.relative_to(root).as_posix())
    return found


# ---- Python


def _statements(node: ast.AST):
    """All nodes but what stands under `if TYPE_CHECKING`, which never runs."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            for other in child.orelse:
                yield from _statements(other)
            continue
        yield child
        yield from _statements(child)


def modules_of(folder: Path, package: str) -> dict:
    """name -> path of the modules of a package; of extension modules, their stubs."""
    modules = {}
    for path in sorted(folder.rglob("*.py*")):
        if path.suffix not in (".py", ".pyi"):
            continue
        parts = [package, *path.relative_to(folder).with_suffix("").parts]
        modules[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return modules


def imports(name: str, path: Path) -> set:
    """Full names that a module imports, at its top or inside functions: of modules, or of things in them."""
    found = set()
    for node in _statements(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = name.split(".")
            if path.name != "__init__.py":
                base = base[:-1]
            base = base[: len(base) - node.level + 1] if node.level else []
            prefix = ".".join([*base, *filter(None, [node.module])])
            found |= {f"{prefix}.{alias.name}" for alias in node.names}
    return found


def import_graph(modules: dict) -> dict:
    """module -> the modules among `modules` that it needs."""
    graph = {}
    for name, path in modules.items():
        needed = set()
        for target in imports(name, path):
            # "package.thing": the module of that name, or the one that holds the thing.
            while target and target not in modules:
                target = target.rpartition(".")[0]
            if target:
                needed.add(target)
        graph[name] = needed - {name}
    return graph
