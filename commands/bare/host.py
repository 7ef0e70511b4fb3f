"""What a bare machine takes over from this one, so that it finds Debian's mirror and PyPI.

The mirror, apt's proxies and passwords, names and addresses, pip's settings with the files and
folders that they name, certificates. Nothing else.
"""

import ast
import configparser
import glob
import os
import re
import subprocess

from commands.paths import SYSTEM_PATH, read

SUITES = ("bookworm", "trixie")
FALLBACK = "https://deb.debian.org/debian"
TARGETS = ("Created-By: Packages", "Origin: Debian", "Label: Debian", "Component: main")
BUNDLE = "/etc/ssl/certs/ca-certificates.crt"
CERTIFICATE = re.compile("-----BEGIN CERTIFICATE-----.*?-----END CERTIFICATE-----", re.DOTALL)
PROXIES = ("http_proxy", "https_proxy", "ftp_proxy", "all_proxy", "no_proxy")
PIP_PLACES = ("find-links", "index-url", "extra-index-url")  # may name folders
PIP_FILES = ("cert", "client-cert", "constraint", "requirement")
PIP_OWN = ("PIP_CACHE_DIR", "PIP_CONFIG_FILE")  # the machine has places of its own
COPIED = ("/etc/resolv.conf", "/etc/hosts", "/etc/apt/auth.conf", "/etc/apt/auth.conf.d/*.conf")


def mirror():
    """Returns the URL of this machine's mirror of Debian; deb.debian.org if it has none."""
    if not _said("apt-get", "indextargets"):
        _said("apt-get", "update")  # apt tells only of lists that it has
    uris = _said("apt-get", "indextargets", "--format", "$(REPO_URI)", *TARGETS).split()
    return next((uri.rstrip("/") for uri in uris if re.match("https?://", uri)), FALLBACK)


def apt_proxies():
    """Returns apt's own settings of proxies as lines of apt.conf."""
    wanted = r'Acquire::https?::(Proxy(::[^ ]+)?|Verify-Peer|Verify-Host) ".+";'
    lines = _said("apt-config", "dump").splitlines()
    return [line for line in lines if re.fullmatch(wanted, line)]


def environment():
    """Returns the variables of the machine: its own, CI and TERM, pip's and the proxies."""
    environ = {"HOME": "/root", "PATH": SYSTEM_PATH, "LANG": "C.UTF-8"}
    for name, value in os.environ.items():
        pip = name.startswith("PIP_") and name not in PIP_OWN
        if pip or name in ("CI", "TERM") or name.lower() in PROXIES:
            environ[name] = value
    return environ


def take_over(root, suite):
    """Writes this machine's settings of the network into another one.

    Returns:
        Files and folders to be seen there at the same path, for pip.
    """
    source = mirror()
    _write(root, "/etc/apt/sources.list", f"deb {source} {suite} main\n")
    proxies = "".join(f"{line}\n" for line in apt_proxies())
    _write(root, "/etc/apt/apt.conf.d/99mmdebstrap", proxies)  # those of when it was made
    for path in (path for pattern in COPIED for path in glob.glob(pattern)):
        _write(root, path, read(path))
    for number, text in enumerate(CERTIFICATE.findall(read(BUNDLE)), 1):
        _write(root, f"/usr/local/share/ca-certificates/host-{number}.crt", f"{text}\n")
    if source.startswith("https:"):  # asked before ca-certificates is installed there
        _write(root, BUNDLE, read(BUNDLE))
    settings = pip_settings()
    conf = configparser.RawConfigParser()
    for section, name, value in settings:
        if section != ":env:":
            conf.read_dict({section: {name: value}})
    with open(f"{root}/etc/pip.conf", "w", encoding="utf-8") as stream:
        conf.write(stream)
    return [path for path in named_by_pip(settings) if not _is_filled(root + path)]


def pip_settings():
    """Lists pip's settings as (section, name, value); of variables the section is ":env:"."""
    result = []
    for line in _said("pip3", "config", "list").splitlines():
        key, _, value = line.partition("=")
        section, _, name = key.rpartition(".")
        result.append((section, name, " ".join(ast.literal_eval(value).split())))
    return result


def named_by_pip(settings):
    """Lists the files and folders of this machine that pip's settings name.

    Of an index it is the parent, where its files may lie; /etc/ssl is ca-certificates' to fill.
    """
    result = set()
    for _section, name, value in settings:
        for word in value.split() if name in PIP_PLACES + PIP_FILES else ():
            path = re.sub("^file://", "", word).rstrip("/")
            if name in PIP_PLACES and (os.path.isfile(path) or path.endswith("/simple")):
                path = os.path.dirname(path)
            if os.path.isabs(path) and os.path.exists(path) and not path.startswith("/etc/ssl/"):
                result.add(path)
    return sorted(result)


def _is_filled(path):
    """Returns whether the machine has something of its own there, which nothing may cover."""
    return os.path.exists(path) and (not os.path.isdir(path) or bool(os.listdir(path)))


def _write(root, path, text):
    os.makedirs(os.path.dirname(root + path), exist_ok=True)
    with open(root + path, "w", encoding="utf-8", errors="surrogateescape") as stream:
        stream.write(text)


def _said(*words):
    """Returns what a program printed; nothing where it failed or is not there."""
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout
