"""The site's pages (a hook of mkdocs.yml): all Markdown files of the repository and the files that they link to, a page for each public
header and one for all that a comment of it declares, and a page for each public name of the Python package, made from its docstring by
mkdocstrings."""
import ast
import os
import re
import subprocess
from pathlib import Path

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
MODULES = ["ffprocams", "ffprocams.protocols", "ffprocams.interop", "ffprocams.torch", "ffprocams.perceptual"]
LINK = re.compile(r"\]\(([^()\s#:]+)[^()\s]*\)")
DECLARED = re.compile(r"^FFP_API [^(]*\b(ffp_\w+)\(|^typedef struct (\w+) \2;|^} (\w+);|^typedef enum (\w+) {.*}|^#define (FFP_(?!API)\w+) |"
                      r"^typedef [^{]*\(\*(\w+)\)|^FFP_DEFAULTS\(\w+, (\w+)\)", re.MULTILINE)
FRAME = re.compile(r"#if(?:ndef|def) (?:\w+_H|__cplusplus)\n(?:extern \"C\" {\n|}\n#endif\n)?|#define \w+_H\n|#include .*\n|^#endif\n", re.MULTILINE)


def headers():
    """The public headers that declare anything, by their paths, without what only a compiler needs."""
    texts = {str(path.relative_to(ROOT)): FRAME.sub("", path.read_text(encoding="utf-8")) for path in (ROOT / "include").rglob("*.h")}
    return {path: text for path, text in texts.items() if names(text)}


def names(code):
    return [next(filter(None, found)) for found in DECLARED.findall(code)]


def blocks(text):
    """(comment, declarations) in their order: a comment belongs to all declarations up to the next comment or empty line."""
    for part in re.split(r"\n\n(?! )", text):
        for comment, code in re.findall(r"((?:^//.*\n?)*)((?:^(?!//).+\n?)*)", part, re.MULTILINE):
            if comment or code:
                yield re.sub(" {2,}", "\n\n", " ".join(line[2:].strip() for line in comment.splitlines())), code


def link(text, target, page):
    return f"[{text}]({os.path.relpath(target, os.path.dirname(page))})"


def link_to(name, page, places):
    return link(f"`{name}`", places[name], page)


def prose(comment, page, places):
    """A comment as Markdown for a page, in which paths of documents and the names in `places` are links."""
    def named(match):
        name = match.group().replace("\\", "")
        return link_to(name, page, places) if name in places else match.group()

    pieces = re.split(r"(`[^`]*`)", comment)
    for i in range(0, len(pieces), 2):
        text = re.sub(r"([\\*_\[\]])", r"\\\1", pieces[i]).replace("<", "&lt;")
        text = re.sub(r"\w+(?:\\_\w+)*", named, text)
        pieces[i] = re.sub(r"\bdocs/[\w/-]+\.md\b", lambda m: link(m.group(), m.group(), page), text)
    return "".join(pieces)


def pages_of_header(path, text, places):
    """The header's page, which lists what it declares, and a page for each comment's declarations."""
    page = f"{path}.md"
    pages = {}
    out = [f"# {os.path.basename(path)}"]
    for comment, code in blocks(text):
        declared = names(code)
        if comment.startswith("--- "):
            title, _, rest = comment.strip("- ").partition(": ")
            out += [f"## {title.removesuffix('.')}", prose(rest[:1].upper() + rest[1:], page, places)]
            continue
        code = re.sub(r"^FFP_DEFAULTS\((\w+), (\w+)\)", r"\1 \2(void);", code.replace("FFP_API ", ""), flags=re.MULTILINE)
        shown = ["```c\n" + code.strip("\n") + "\n```"] if code else []
        if not declared:
            out += [prose(comment, page, places), *shown]
            continue
        own = places[declared[0]]
        begin = [f"# {', '.join(f'`{name}`' for name in declared)}", f"In [{os.path.basename(path)}]({os.path.relpath(page, os.path.dirname(own))})."]
        pages[own] = "\n\n".join([*begin, prose(comment, own, places), *shown]) + "\n"
        first = re.match(r".*?\.(?= |$)|.*", comment, re.DOTALL).group()
        out += [" ".join([", ".join(link_to(name, page, places) for name in declared) + ".", prose(first, page, places)])]
    return {page: "\n\n".join(out) + "\n", **pages}


def pages_of_python():
    """A page that lists the modules' public names, and a page for each of them."""
    out, pages = ["# Python API"], {}
    for module in MODULES:
        file = ROOT / "python" / module.replace(".", "/")
        tree = ast.parse((file / "__init__.py" if file.is_dir() else file.with_suffix(".py")).read_text("utf-8"))
        kinds = (ast.FunctionDef, ast.ClassDef)
        public = [node.name for node in tree.body if isinstance(node, kinds) and not node.name.startswith("_")]
        for node in tree.body:
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
                public = [name for name in ast.literal_eval(node.value) if f"ffprocams.{name}" not in MODULES]
        out += [f"::: {module}\n    options: {{members: false}}", ", ".join(f"[`{name}`](api/{module}.{name}.md)" for name in public)]
        pages |= {f"python/api/{module}.{name}.md": f"# `{name}`\n\n::: {module}.{name}\n" for name in public}
    return {"python/api.md": "\n\n".join(out) + "\n", **pages}


def on_config(config):
    version = re.search(r"VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8").partition("project(")[2]).group(1)
    config.copyright = f"Version {version}"
    config.extra_css.append("site.css")
    return config


def on_files(files, config):
    tracked = subprocess.check_output(["git", "ls-files", "*.md"], cwd=ROOT, text=True).split()
    linked = {(ROOT / page).parent.joinpath(target).resolve() for page in tracked for target in LINK.findall((ROOT / page).read_text("utf-8"))}
    shown = tracked + sorted(str(path.relative_to(ROOT)) for path in linked if path.is_file() and path.suffix not in {".md", ".h"})
    pages = [File.generated(config, path, abs_src_path=str(ROOT / path)) for path in shown]
    declared = [names(code) for text in headers().values() for _, code in blocks(text)]
    places = {name: f"include/ffprocams/{together[0]}.md" for together in declared for name in together}
    made = pages_of_python()
    for path, text in headers().items():
        made |= pages_of_header(path, text, places)
    made["site.css"] = ".md-grid { max-width: 80rem; }\n"  # lines of code in the headers are long
    pages += [File.generated(config, path, content=content) for path, content in made.items()]
    return Files([*(file for file in files if file.src_dir != config.docs_dir), *pages])  # beside those of the theme


def on_page_markdown(markdown, page, config, files):
    """A link to a header goes to its page; a pipe in the code of a table's cell is written as this Markdown parser reads it."""
    markdown = re.sub(r"`[^`\n]*`", lambda m: m.group().replace("\\|", "|"), markdown)
    return re.sub(r"(\]\([^()\s]*include/ffprocams[\w/]*\.h)\)", r"\1.md)", markdown)
