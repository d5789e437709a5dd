#!/usr/bin/env python3
"""The house keeps to its drawing: the table of rooms in CONTRIBUTING.md is the rule, and this test reads it.

An include must follow an arrow of the table; every folder with sources has a row, and every row a folder; the arrows form no circle. A file
that README.md, CONTRIBUTING.md or docs/ names must exist. Last, the test seeds faults into copies of the tree: each must be found.

Usage: arrows.py ROOT
"""
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

SOURCES = (".cpp", ".hpp", ".c", ".h")
TABLE_HEAD = "| Room | What is in it | May include |"
PUBLIC, PRIVATE = "dragcore/include/dragcore", "dragcore/src"
NOT_OURS = {".git", "build", "node_modules", "__pycache__", ".dragval", "report"}  # "report": only as results/report, see tree()


def tree(root):
    """Every file of the repository, relative to `root`; what builds and runs leave behind is not of it."""
    for folder, folders, files in os.walk(root):
        here = Path(folder).relative_to(root)
        folders[:] = sorted(f for f in folders if f not in NOT_OURS or (f == "report" and here != Path("results")))
        yield from (str(here / f) for f in files)


def read_table(text):
    """{room: (description, what it may include)} as the table has it, with siblings written out."""
    lines = text.splitlines()
    if TABLE_HEAD not in lines:
        raise SystemExit(f"CONTRIBUTING.md: no table with the head '{TABLE_HEAD}'")
    rows = {}
    for line in lines[lines.index(TABLE_HEAD) + 2:]:
        if not line.startswith("|"):
            break
        room, description, arrows = (cell.strip() for cell in line.strip("|").split("|"))
        rows[room.strip("`")] = (description, re.findall(r"`([^`]+)`", arrows))
    rooms = {}
    for room, (description, arrows) in rows.items():
        allowed = set()
        for arrow in arrows:
            name = arrow if "/" in arrow or arrow == "*" else f"{room.rpartition('/')[0]}/{arrow}"
            star = name.endswith("*")
            allowed |= {r for r in rows if r.startswith(name[:-1])} - {room} if star else {name}
        rooms[room] = (description, allowed)
    return rooms


def include_faults(root, files, rooms):
    """Faults of the rooms and of every include between them."""
    faults = [f"CONTRIBUTING.md: the table has the room '{room}', which is not there" for room in rooms if not (root / room).is_dir()]
    for room, (_, allowed) in rooms.items():
        faults += [f"CONTRIBUTING.md: '{room}' may include '{name}', which is no room of the table"
                   for name in sorted(allowed - rooms.keys())]
    faults += [f"CONTRIBUTING.md: the table has no row for the folder '{top}'"
               for top in sorted({f.split("/")[0] for f in files if "/" in f and not f.startswith(".")})
               if not any(room == top or room.startswith(top + "/") for room in rooms)]

    present = set(files)
    by_header = {header: room for room, (description, _) in rooms.items() for header in re.findall(r"`(\w+\.hpp|\w+\.h)`", description)}

    def room_of(file):
        folder, _, name = file.rpartition("/")
        if folder == PUBLIC:  # the room of its source, else the one that names it
            own = [room for room in rooms if room.startswith(PRIVATE + "/") and f"{room}/{name.rpartition('.')[0]}.cpp" in present]
            return own[0] if own else by_header.get(name)
        return max((room for room in rooms if file.startswith(room + "/")), key=len, default=None)

    def target_of(file, name):
        for base in (os.path.dirname(file), "", "dragcore/include", PRIVATE):
            path = os.path.normpath(os.path.join(base, name))
            if path in present:
                return path
        return None

    for file in sorted(f for f in files if f.endswith(SOURCES)):
        room = room_of(file)
        if room is None:
            faults.append(f"{file}: in no room of the table in CONTRIBUTING.md; " + (
                f"name `{os.path.basename(file)}` in the row that it belongs to" if file.startswith(PUBLIC) else "give its folder a row"))
            continue
        for number, line in enumerate((root / file).read_text(encoding="utf-8").splitlines(), 1):
            match = re.match(r'\s*#\s*include\s*([<"])([^>"]+)', line)
            if not match:
                continue
            target = target_of(file, match[2])
            if target is None:
                if match[1] == '"':
                    faults.append(f"{file}:{number}: includes '{match[2]}', which is not there")
                continue
            to = room_of(target)
            if to is not None and to != room and to not in rooms[room][1]:
                may = ", ".join(sorted(rooms[room][1])) or "nothing"
                faults.append(f"{file}:{number}: {room} includes {target} of {to}, but may include {may}")
            if target.startswith(PRIVATE + "/") and (file.startswith(PUBLIC) or not file.startswith(("dragcore/", "tests/"))):
                faults.append(f"{file}:{number}: {target} is private to dragcore")
    return faults


def circle_faults(rooms):
    """A room that reaches itself along the arrows."""
    def reached(room):
        seen, next_ones = set(), [room]
        while next_ones:
            for name in rooms.get(next_ones.pop(), ("", ()))[1]:
                if name not in seen:
                    seen.add(name)
                    next_ones.append(name)
        return seen
    return [f"CONTRIBUTING.md: the arrows from '{room}' lead back to it" for room in rooms if room in reached(room)]


def made_patterns(root):
    """Folders and files that .gitignore calls made."""
    return [line.strip("/") for line in (root / ".gitignore").read_text().splitlines() if line.startswith("/")] + ["build"]


def anchors(page):
    """What a link can point at: headings, as GitHub makes anchors of them, and names given by hand."""
    text = page.read_text(encoding="utf-8")
    headings = re.findall(r"^#+ (.*)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", h.strip().lower()).replace(" ", "-") for h in headings} | set(re.findall(r'<a name="([^"]+)"', text))


def path_faults(root, files):
    """Files that the documents name but nobody has; and, not as faults, those that a command has yet to make."""
    faults, unmade, made = [], set(), made_patterns(root)
    names = {os.path.basename(f) for f in files}
    folders = {str(p) for f in files for p in Path(f).parents}
    tops = {f.split("/")[0] for f in files if "/" in f} | set(made)
    known = set(files) | folders

    def there(path):
        path = path.rstrip("/")
        if "*" in path:
            return any(root.glob(path))
        return path in known or f"dragcore/include/{path}" in known

    documents = ["README.md", "CONTRIBUTING.md"] + sorted(f for f in files if re.fullmatch(r"docs/[^/]+\.md", f))
    for document in documents:
        for number, line in enumerate((root / document).read_text(encoding="utf-8").splitlines(), 1):
            for link in re.findall(r"\]\(([^)\s]+)\)", line):
                if re.match(r"\w+:", link):
                    continue
                path, _, anchor = link.partition("#")
                target = os.path.normpath(os.path.join(os.path.dirname(document), path)) if path else document
                if target not in known:
                    faults.append(f"{document}:{number}: links to '{path}', which is not there")
                elif anchor and anchor not in anchors(root / target):
                    faults.append(f"{document}:{number}: '{target}' has no heading '#{anchor}'")
            for word in (w.strip("\"',;:()") for code in re.findall(r"`([^`]+)`", line) for w in code.split()):
                if re.search(r"[<>…{}|$]", word):  # a place holder
                    continue
                if "/" in word and word.split("/")[0] in tops:
                    if any(word == m or word.startswith(m + "/") for m in made):
                        if not (root / word).exists():
                            unmade.add(word)
                    elif not there(word):
                        faults.append(f"{document}:{number}: names '{word}', which is not there")
                elif re.fullmatch(r"\w+\.(cpp|hpp|py|sh|mjs)", word) and word not in names:
                    faults.append(f"{document}:{number}: names '{word}', and no folder has it")
    return faults, unmade


def check(root):
    root = Path(root)
    files = list(tree(root))
    rooms = read_table((root / "CONTRIBUTING.md").read_text(encoding="utf-8"))
    wrong_paths, unmade = path_faults(root, files)
    return include_faults(root, files, rooms) + circle_faults(rooms) + wrong_paths, unmade


def prove(root):
    """Seeds one fault at a time into a copy; returns those that were not found."""
    def append(file, line):
        def seed(copy):
            path = copy / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text((path.read_text(encoding="utf-8") if path.exists() else "") + line + "\n", encoding="utf-8")
        return seed

    def edit_rows(edit):
        def seed(copy):
            path = copy / "CONTRIBUTING.md"
            path.write_text("\n".join(edit(path.read_text(encoding="utf-8").split("\n"))), encoding="utf-8")
        return seed

    def row(room, arrows):
        def insert(lines):
            first = lines.index(TABLE_HEAD) + 2
            return lines[:first] + [f"| `{room}` | seeded | {arrows} |"] + lines[first:]
        return insert

    seeds = {
        "compare/store includes compare/cli/commands.hpp": append("compare/store/store.cpp", '#include "compare/cli/commands.hpp"'),
        "cfd_cases/mesh includes dragcore/include/dragcore/drag.hpp": append(
            "cfd_cases/mesh/cell_count.cpp", "#include <dragcore/drag.hpp>"),
        "dragcore/src/body includes compare/": append("dragcore/src/body/pose.cpp", '#include "compare/case_record/case_record.hpp"'),
        "is private to dragcore": append("compare/calibration/prediction.cpp", '#include "dragcore/src/drag/check.hpp"'),
        "'no_such.hpp', which is not there": append("compare/gate/gate.cpp", '#include "no_such.hpp"'),
        "compare/attic/attic.cpp: in no room": append("compare/attic/attic.cpp", "int attic;"),
        "dragcore/nowhere.hpp: in no room": append(f"{PUBLIC}/nowhere.hpp", "#pragma once"),
        "the table has the room 'compare/cellar', which is not there": edit_rows(row("compare/cellar", "nothing")),
        "compare/gate/gate.cpp: in no room": edit_rows(lambda lines: [l for l in lines if not l.startswith("| `compare/gate` |")]),
        "lead back to it": edit_rows(lambda lines: [
            l.rstrip(" |") + ", `gate` |" if l.startswith("| `compare/tables` |") else l for l in lines]),
        "names 'scripts/no_such.sh'": append("docs/conventions.md", "`scripts/no_such.sh`"),
        "links to 'no_such.md'": append("docs/conventions.md", "[x](no_such.md)"),
        "has no heading '#no-such'": append("docs/conventions.md", "[x](cfd.md#no-such)"),
    }
    missed = []
    for fault, seed in seeds.items():
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / "copy"
            for file in tree(root):
                (copy / file).parent.mkdir(parents=True, exist_ok=True)
                if file.endswith(SOURCES + (".md", ".gitignore")):
                    shutil.copy(root / file, copy / file)
                else:
                    (copy / file).touch()  # that it is there is all that counts
            seed(copy)
            found = [f for f in check(copy)[0] if fault in f]
        if not found:
            missed.append(f"a seeded fault was not found: {fault}")
    return missed


root = Path(sys.argv[1]).resolve()
faults, unmade = check(root)
faults = faults or prove(root)
if unmade:
    print("documents name what a command has yet to make:", ", ".join(sorted(unmade)))
print("\n".join(faults) or "the house is as CONTRIBUTING.md draws it")
sys.exit(bool(faults))
