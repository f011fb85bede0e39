# SPDX-License-Identifier: Apache-2.0
"""Reference pages made from the program's help, its options, and the Python package's stubs."""

import ast
import json
import re
import subprocess


def run(program, *arguments):
    done = subprocess.run([program, *arguments], capture_output=True, text=True)
    return done.stdout if done.returncode == 0 else None


def subcommands(help_text):
    listed = re.search(r"\nSubcommands:\n((?:  .*\n)+)", help_text)
    return re.findall(r"^  ([a-z]\S*) ", listed.group(1), re.MULTILINE) if listed else []


def all_commands(program, path=()):
    """Each command as (its words, its help), subcommands after their command."""
    text = run(program, *path, "--help")
    yield path, text
    for name in subcommands(text):
        yield from all_commands(program, (*path, name))


def commands_page(program):
    parts = ["# Commands", "The output of `--help`, command by command."]
    for path, text in all_commands(program):
        title = " ".join(("palpate", *path))
        parts += [f"{'##' if len(path) < 2 else '###'} {title}", f"```text\n{text.rstrip()}\n```"]
    return "\n\n".join(parts) + "\n"


def cell(text):
    return text.replace("|", "\\|").replace("\n", " ")


def key_cell(key):
    """A key that may be broken after a dot or an underscore, and is copied without the break."""
    return "<code>" + key.replace(".", ".<wbr>").replace("_", "_<wbr>") + "</code>"


def option_rows(options):
    yield "| key | default | range | what it is |"
    yield "|---|---|---|---|"
    for option in options:
        yield (f"| {key_cell(option['key'])} | {cell(option['default'])} | {cell(option['range'])} "
               f"| {cell(option['help'])} |")  # fmt: skip


def options_page(program):
    parts = [
        "# Options",
        "What `--config FILE` and `--set KEY=VALUE` can set, command by command. "
        "Options of the section `expert` may change from version to version.",
    ]
    titles = {}
    for path in (path for path, text in all_commands(program) if "--set KEY=VALUE" in text):
        text = run(program, "options", *path, "--expert", "--json")
        table = "\n".join(option_rows(json.loads(text)["options"]))
        title = " ".join(("palpate", *path))
        first = titles.setdefault(table, title)
        parts += [f"## {title}", table if first == title else f"The same as those of `{first}`."]
    return "\n\n".join(parts) + "\n"


def annotation_free(arguments):
    """`(points, normals=None)`: the stubs' types are long, and the docstrings name shapes."""
    names = [argument.arg for argument in arguments.args if argument.arg != "self"]
    defaults = [None] * (len(names) - len(arguments.defaults)) + list(arguments.defaults)
    shown = [name if default is None else f"{name}={ast.unparse(default)}"
             for name, default in zip(names, defaults)]  # fmt: skip
    if arguments.kwonlyargs:
        shown.append("*")
        for argument, default in zip(arguments.kwonlyargs, arguments.kw_defaults):
            shown.append(argument.arg + (f"={ast.unparse(default)}" if default else ""))
    return f"({', '.join(shown)})"


def is_property(function):
    return any(ast.unparse(d) in ("property", "staticmethod") for d in function.decorator_list)


def documented(node):
    """The functions of a module or class that users call or read."""
    for child in node.body:
        if isinstance(child, ast.FunctionDef):
            if child.name == "__init__" or not child.name.startswith("_"):
                yield child


def function_entry(function, prefix):
    name = prefix if function.name == "__init__" else f"{prefix}{function.name}"
    signature = "" if is_property(function) else annotation_free(function.args)
    text = (ast.get_docstring(function) or "").replace("\n", "\n  ")
    return f"- `{name}{signature}`" + (f"\n\n  {text}" if text else "")


def cpp_page(has_doxygen):
    link = ('<a href="../cpp/index.html">All headers, made by Doxygen</a>' if has_doxygen
            else "Made by Doxygen, which this site was built without.")  # fmt: skip
    return f"# C++ API\n\n{link}\n\n[The C++ library](../docs/library.md) says where to start.\n"


def python_page(stubs):
    if not stubs:
        return "# Python API\n\nThis site was built without the Python package.\n"
    tree = ast.parse(stubs)
    parts = ["# Python API", "Made from the stubs of `palpate`. Poses are (4, 4) float64 in C order, "
             "points (N, 3), lengths m, angles rad; see [the guide](../docs/python.md)."]  # fmt: skip
    parts.append("## Functions")
    parts += [function_entry(function, "palpate.") for function in documented(tree)]
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            parts += [f"## {node.name}", ast.get_docstring(node) or ""]
            parts += [function_entry(f, f"{node.name}" if f.name == "__init__" else ".")
                      for f in documented(node)]  # fmt: skip
    return "\n\n".join(parts) + "\n"
