#!/usr/bin/env python3
"""Writes what the program is made of, as an SPDX 2.3 document: itself, the libraries that it links
at run time, those whose headers were compiled into it, and the font of the pictures. Versions and
licences are those of the Debian packages on this machine.

  scripts/write_sbom.py PROGRAM OUT.spdx.json
"""
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys

from program_help import output_of

# Their headers are in the program; by the package that brings them.
COMPILED_IN = [
    "libeigen3-dev",
    "libboost-dev",
    "nlohmann-json3-dev",
    "libcli11-dev",
    "libfmt-dev",
    "libspdlog-dev",
    "libtomlplusplus-dev",
    "libyaml-cpp-dev",
    "libtbb-dev",
    "libhwy-dev",
]
# Of scripts/write_font.py; its outlines are in the sources, not taken from this machine.
FONT = {
    "SPDXID": "SPDXRef-dejavu-sans",
    "name": "dejavu-sans",
    "versionInfo": "2.37",
    "downloadLocation": "https://dejavu-fonts.github.io",
    "filesAnalyzed": False,
    "licenseConcluded": "Bitstream-Vera",
    "licenseDeclared": "Bitstream-Vera",
    "copyrightText": "Copyright (c) 2003 by Bitstream, Inc. DejaVu changes are in public domain.",
}
# SPDX's names of what Debian's copyright files call otherwise.
SPDX_NAMES = {
    "Expat": "MIT",
    "MIT/X11": "MIT",
    "BSL-1.0": "BSL-1.0",
    "Apache-2.0": "Apache-2.0",
    "Apache-2": "Apache-2.0",
    "MPL-2": "MPL-2.0",
    "MPL-2.0": "MPL-2.0",
    "BSD-3-clause": "BSD-3-Clause",
    "BSD-3-Clause": "BSD-3-Clause",
    "BSD-2-clause": "BSD-2-Clause",
    "Zlib": "Zlib",
    "zlib": "Zlib",
}


def linked_packages(program):
    """What the dynamic linker loads, by package."""
    paths = sorted(set(re.findall(r"=> (/\S+)", output_of("ldd", program))))
    packages = set()
    for path in paths:
        # The linker may know a file under /lib that dpkg knows under /usr/lib, or the other way.
        for name in (
            path,
            str(pathlib.Path(path).resolve()),
            "/usr" + path,
            path.removeprefix("/usr"),
        ):
            found = subprocess.run(["dpkg", "-S", name], capture_output=True, text=True).stdout
            if found:
                packages.add(found.split(":")[0])
                break
        else:
            raise SystemExit(f"{path} is of no package")
    return sorted(packages)


def version_of(package):
    return output_of("dpkg-query", "-W", "-f=${Version}", package)


def licence_of(package):
    """That of the package's files at large, where its copyright file says so in SPDX's words or
    Debian's; else that nothing is asserted."""
    path = pathlib.Path(f"/usr/share/doc/{package}/copyright")
    text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
    whole = re.search(r"^Files: ?\n? *\*\s*\n(?:.*\n)*?License: *(\S+)", text, re.M)
    return SPDX_NAMES.get(whole.group(1), "NOASSERTION") if whole else "NOASSERTION"


def package_entry(package):
    version = version_of(package)
    name = re.sub(r"[^A-Za-z0-9.-]", "-", package)
    return {
        "SPDXID": f"SPDXRef-{name}",
        "name": package,
        "versionInfo": version,
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "licenseConcluded": "NOASSERTION",
        "licenseDeclared": licence_of(package),
        "copyrightText": "NOASSERTION",
        "externalRefs": [
            {
                "referenceCategory": "PACKAGE-MANAGER",
                "referenceType": "purl",
                "referenceLocator": f"pkg:deb/debian/{package}@{version}",
            }
        ],
    }


def document(program):
    version = output_of(program, "--version").split()[-1]
    digest = hashlib.sha256(pathlib.Path(program).read_bytes()).hexdigest()
    made = datetime.datetime.fromtimestamp(
        int(os.environ.get("SOURCE_DATE_EPOCH", "0")), datetime.timezone.utc
    )
    itself = {
        "SPDXID": "SPDXRef-loopstone",
        "name": "loopstone",
        "versionInfo": version,
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "licenseConcluded": "Apache-2.0",
        "licenseDeclared": "Apache-2.0",
        "copyrightText": "The Loopstone developers",
        "checksums": [{"algorithm": "SHA256", "checksumValue": digest}],
        "primaryPackagePurpose": "APPLICATION",
    }
    linked, compiled = linked_packages(program), COMPILED_IN
    entries = {name: package_entry(name) for name in sorted({*linked, *compiled})}
    relations = [("SPDXRef-DOCUMENT", "DESCRIBES", itself["SPDXID"])]
    relations += [(itself["SPDXID"], "DYNAMIC_LINK", entries[name]["SPDXID"]) for name in linked]
    relations += [(itself["SPDXID"], "CONTAINS", entries[name]["SPDXID"]) for name in compiled]
    relations.append((itself["SPDXID"], "CONTAINS", FONT["SPDXID"]))
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"loopstone-{version}",
        "documentNamespace": f"https://loopstone.invalid/spdx/{version}/{digest}",
        "creationInfo": {
            "created": made.strftime("%Y-%m-%dT%H:%M:%SZ"),
            "creators": ["Tool: loopstone-write_sbom.py"],
        },
        "packages": [itself, *entries.values(), FONT],
        "relationships": [
            {"spdxElementId": a, "relationshipType": how, "relatedSpdxElement": b}
            for a, how, b in relations
        ],
    }


def main():
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    program, out = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2])
    text = json.dumps(document(program), indent=1) + "\n"
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
