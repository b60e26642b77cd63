"""The site's pages (a hook of mkdocs.yml): all Markdown files of the repository and the files that they link to, a page for each public
header, made from its comments, and one for the Python package, made from its docstrings by mkdocstrings."""
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


def prose(comment, page, places):
    """A comment as Markdown for a page, in which paths of documents and the names in `places` are links."""
    def link(text, target):
        return f"[{text}]({os.path.relpath(target, os.path.dirname(page))})"

    def named(match):
        name = match.group().replace("\\", "")
        return link(f"`{name}`", places[name]) if name in places else match.group()

    pieces = re.split(r"(`[^`]*`)", comment)
    for i in range(0, len(pieces), 2):
        text = re.sub(r"([\\*_\[\]])", r"\\\1", pieces[i]).replace("<", "&lt;")
        text = re.sub(r"\w+(?:\\_\w+)*", named, text)
        pieces[i] = re.sub(r"\bdocs/[\w/-]+\.md\b", lambda m: link(m.group(), m.group()), text)
    return "".join(pieces)


def page_of_header(text, page, places):
    out = [f"# {os.path.basename(page).removesuffix('.md')}"]
    for comment, code in blocks(text):
        declared = names(code)
        if comment.startswith("--- "):
            title, _, rest = comment.strip("- ").partition(": ")
            out += [f"## {title.removesuffix('.')}", prose(rest[:1].upper() + rest[1:], page, places)]
            continue
        if declared:
            out += ["### " + ", ".join(f"`{name}`" for name in declared) + f" {{#{declared[0]}}}"]
            out += ["".join(f"[](){{#{name}}}" for name in declared[1:])]
        out += [prose(comment, page, places)]
        if code:
            code = re.sub(r"^FFP_DEFAULTS\((\w+), (\w+)\)", r"\1 \2(void);", code.replace("FFP_API ", ""), flags=re.MULTILINE)
            out += ["```c\n" + code.strip("\n") + "\n```"]
    return "\n\n".join(out) + "\n"


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
    places = {name: f"{path}.md#{name}" for path, text in headers().items() for name in names(text)}
    made = {f"{path}.md": page_of_header(text, f"{path}.md", places) for path, text in headers().items()}
    made["python/api.md"] = "# Python API\n\n" + "".join(f"::: {module}\n\n" for module in MODULES)
    made["site.css"] = ".md-grid { max-width: 80rem; }\n"  # lines of code in the headers are long
    pages += [File.generated(config, path, content=content) for path, content in made.items()]
    return Files([*(file for file in files if file.src_dir != config.docs_dir), *pages])  # beside those of the theme


def on_page_markdown(markdown, page, config, files):
    """A link to a header goes to its page; a pipe in the code of a table's cell is written as this Markdown parser reads it."""
    markdown = re.sub(r"`[^`\n]*`", lambda m: m.group().replace("\\|", "|"), markdown)
    return re.sub(r"(\]\([^()\s]*include/ffprocams[\w/]*\.h)\)", r"\1.md)", markdown)
