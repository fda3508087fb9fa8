"""Looks whether any build script of the packages in `cargo metadata` (stdin) could fetch something.

What a build script can do it can do by itself, by a package that it is built with, or by a program that it starts.
So its own text is searched for words of networks and for such programs, and what it is built with for packages that
open connections. A word is no proof: what is known and harmless stands in KNOWN, with its reason.
"""

import json
import pathlib
import re
import sys

WORDS = re.compile(r"std::net|TcpStream|reqwest|ureq|hyper::|git2|\b(curl|wget|git clone|cargo install)\b|https?_?client", re.I)
PACKAGES = {"reqwest", "ureq", "curl", "hyper", "git2", "gix", "attohttpc", "minreq", "isahc", "tokio"}
KNOWN: dict[str, str] = {}

metadata = json.load(sys.stdin)
packages = {package["id"]: package for package in metadata["packages"]}
scripts, wrong = 0, []
for node in metadata["resolve"]["nodes"]:
    package = packages[node["id"]]
    for target in package["targets"]:
        if "custom-build" not in target["kind"]:
            continue
        scripts += 1
        main = pathlib.Path(target["src_path"])
        files = [main, *main.parent.glob("build/**/*.rs")]
        for file in files:
            for number, line in enumerate(file.read_text(errors="replace").splitlines(), 1):
                if WORDS.search(line) and not line.strip().startswith("//"):
                    wrong.append(f"{package['name']} {package['version']}: {file.name}:{number}: {line.strip()[:100]}")
        with_what = {packages[dep["pkg"]]["name"] for dep in node["deps"] if any(kind["kind"] == "build" for kind in dep["dep_kinds"])}
        wrong += [f"{package['name']} {package['version']}: is built with {name}" for name in sorted(with_what & PACKAGES)]
wrong = [line for line in wrong if line.split()[0] not in KNOWN]
print(f"{len(metadata['resolve']['nodes'])} packages, {scripts} build scripts, {len(wrong)} that may fetch something")
print("\n".join(wrong), end="\n" if wrong else "")
sys.exit(bool(wrong))
