"""What a bare machine takes over from this one, so that it finds Debian's mirror and PyPI.

The mirror, apt's proxies and passwords, names and addresses, pip's settings with the files and
folders that they name, certificates that Debian does not know. Nothing else.
"""

import configparser
import glob
import os
import re
import shutil
import subprocess

from commands.paths import SYSTEM_PATH, read

SUITES = ("bookworm", "trixie")
FALLBACK = "https://deb.debian.org/debian"
OWN_LISTS = ("sources.list", "debian.sources")  # whose first source is Debian's wherever it lies
NAMES = ("stable", "testing", "unstable", "sid", "bullseye", "forky", *SUITES)
BUNDLE = "/etc/ssl/certs/ca-certificates.crt"
CERTIFICATE = re.compile("-----BEGIN CERTIFICATE-----.*?-----END CERTIFICATE-----", re.DOTALL)
PROXIES = ("http_proxy", "https_proxy", "ftp_proxy", "all_proxy", "no_proxy")
PIP_PLACES = ("find-links", "index-url", "extra-index-url")  # may name folders
PIP_FILES = ("cert", "client-cert", "constraint", "requirement")
PIP_OWN = ("PIP_CACHE_DIR",)  # the machine has a place of its own


def mirror(folder="/etc/apt"):
    """Finds this machine's mirror of Debian.

    Args:
        folder: With sources.list and sources.list.d/.

    Returns:
        URL; deb.debian.org if no file names one.
    """
    more = sorted(glob.glob(f"{folder}/sources.list.d/*"))
    for path in sorted([f"{folder}/sources.list", *more], key=_is_third_party):
        for uri, suite, components, keyring in sources(path, read(path)):
            debian = keyring is None or "debian-archive" in keyring
            named = not _is_third_party(path) or uri.rstrip("/").endswith("/debian")
            if debian and named and suite in NAMES and "main" in components:
                return uri.rstrip("/")
    return FALLBACK


def sources(path, text):
    """Reads one of apt's lists.

    Args:
        path: Its suffix tells the format: .list (a line each) or .sources (deb822).

    Yields:
        (URI, suite, list of components, signed-by or None) of each enabled source of packages that
        is reached by http or https.
    """
    if path.endswith(".list"):
        found = map(_of_line, text.splitlines())
    elif path.endswith(".sources"):
        found = (entry for stanza in re.split(r"\n\s*\n", text) for entry in _of_stanza(stanza))
    else:
        return
    yield from (entry for entry in found if entry and re.match(r"https?://", entry[0]))


def _is_third_party(path):
    return os.path.basename(path) not in OWN_LISTS


def _of_line(line):
    match = re.match(r"\s*deb\s+(?:\[(?P<options>[^\]]*)\]\s*)?(?P<rest>[^#]*)", line)
    if not match or len(match["rest"].split()) < 2:
        return None
    uri, suite, *components = match["rest"].split()
    keyring = re.search(r"signed-by\s*=\s*(\S+)", match["options"] or "", re.IGNORECASE)
    return uri, suite, components, keyring and keyring[1]


def _of_stanza(stanza):
    text = "\n".join(line for line in stanza.splitlines() if not line.startswith("#"))
    pairs = re.findall(r"^([\w-]+):(.*(?:\n[ \t].*)*)", text, re.MULTILINE)
    fields = {name.lower(): value.strip() for name, value in pairs}
    disabled = fields.get("enabled", "").lower() in ("no", "false", "0")
    if disabled or "deb" not in fields.get("types", "").split():
        return
    components = fields.get("components", "").split()
    for uri in fields.get("uris", "").split():
        for suite in fields.get("suites", "").split():
            yield uri, suite, components, fields.get("signed-by")


def apt_proxies():
    """Returns apt's own settings of proxies as lines of apt.conf."""
    try:
        dump = subprocess.run(["apt-config", "dump"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return []
    wanted = r'Acquire::https?::(Proxy(::[^ ]+)?|Verify-Peer|Verify-Host) ".+";'
    return [line for line in dump.stdout.splitlines() if re.fullmatch(wanted, line)]


def environment():
    """Returns the variables of the machine: its own, CI and TERM, pip's and the proxies."""
    environ = {"HOME": "/root", "PATH": SYSTEM_PATH, "LANG": "C.UTF-8"}
    for name, value in os.environ.items():
        pip = name.startswith("PIP_") and name not in PIP_OWN
        if pip or name in ("CI", "TERM") or name.lower() in PROXIES:
            environ[name] = value
    return environ


def for_debootstrap():
    """Returns the variables for debootstrap: these, with apt's proxy, which wget does not know."""
    environ = dict(os.environ)
    for line in apt_proxies():
        match = re.fullmatch(r'Acquire::(https?)::Proxy "(https?://.*)";', line)
        if match:
            environ.setdefault(f"{match[1]}_proxy", match[2])
    return environ


def take_over(root, suite):
    """Writes this machine's settings of the network into another one.

    Returns:
        Folders to be seen there at the same path, for pip.
    """
    source = mirror()
    _write(root, "/etc/apt/sources.list", f"deb {source} {suite} main\n")
    _write(root, "/etc/dpkg/dpkg.cfg.d/fast", "force-unsafe-io\n")  # it need not outlive a crash
    _write(root, "/etc/apt/apt.conf.d/90network", "".join(f"{line}\n" for line in apt_proxies()))
    for path in ("/etc/resolv.conf", "/etc/hosts", "/etc/apt/auth.conf"):
        _copy(path, root)
    for path in glob.glob("/etc/apt/auth.conf.d/*.conf"):
        _copy(path, root)
    for number, text in enumerate(local_certificates(), 1):
        _write(root, f"/usr/local/share/ca-certificates/host-{number}.crt", f"{text}\n")
    if source.startswith("https:"):  # asked before ca-certificates is installed there
        _copy(BUNDLE, root)
    folders, files = named_by_pip(_take_over_pip(root))
    for path in files:
        if not path.startswith("/etc/ssl/"):  # which ca-certificates brings
            _copy(path, root)
    return [path for path in folders if not _is_filled(root + path)]


def local_certificates():
    """Lists the certificates (PEM) that this machine trusts and Debian's own list has not."""
    known = set()
    for path in glob.glob("/usr/share/ca-certificates/**/*.crt", recursive=True):
        known |= {"".join(text.split()) for text in CERTIFICATE.findall(read(path))}
    trusted = CERTIFICATE.findall(read(BUNDLE)) if known else []
    for path in glob.glob("/usr/local/share/ca-certificates/**/*.crt", recursive=True):
        trusted += CERTIFICATE.findall(read(path))
    found = {"".join(text.split()): text for text in trusted}
    return [text for key, text in found.items() if key not in known]


def _take_over_pip(root):
    """Copies pip's files; gives their settings and those of the environment.

    Returns:
        List of (name, value), the name as in a file.
    """
    home = os.path.expanduser("~")
    config = os.environ.get("XDG_CONFIG_HOME") or os.path.join(home, ".config")
    files = {
        "/etc/xdg/pip/pip.conf": "/etc/xdg/pip/pip.conf",
        "/etc/pip.conf": "/etc/pip.conf",
        os.path.join(home, ".pip", "pip.conf"): "/root/.pip/pip.conf",
        os.path.join(config, "pip", "pip.conf"): "/root/.config/pip/pip.conf",
    }
    named = os.environ.get("PIP_CONFIG_FILE")
    if named and os.path.isabs(named):
        files[named] = named
    settings = []
    for path, there in files.items():
        if os.path.isfile(path):
            _copy(path, root, there)
            settings += pip_settings(read(path))
    settings += [
        (name[len("PIP_") :].lower().replace("_", "-"), value)
        for name, value in os.environ.items()
        if name.startswith("PIP_")
    ]
    return settings


def pip_settings(text):
    """Reads a pip.conf; one that cannot be read is pip's to complain of.

    Returns:
        List of (name, value).
    """
    parser = configparser.RawConfigParser()
    try:
        parser.read_string(text)
    except configparser.Error:
        return []
    return [
        (name.replace("_", "-"), value)
        for section in parser.sections()
        for name, value in parser.items(section)
    ]


def named_by_pip(settings):
    """Finds what pip's settings name on this machine.

    Args:
        settings: List of (name, value).

    Returns:
        folders: That packages are found in; of an index its parent, where its files may lie.
        files: Such as certificates.
    """
    folders, files = [], []
    for name, value in settings:
        for word in value.split():
            path = re.sub("^file://", "", word).rstrip("/")
            if name in PIP_PLACES and path.startswith("/"):
                if not os.path.isdir(path) or os.path.basename(path) == "simple":
                    path = os.path.dirname(path)
                folders.append(path)
            elif name in PIP_FILES and path.startswith("/"):
                files.append(path)
    return sorted({path for path in folders if os.path.isdir(path)}), sorted(
        {path for path in files if os.path.isfile(path)}
    )


def _is_filled(folder):
    """Returns whether the machine has something of its own there, which nothing may cover."""
    return os.path.exists(folder) and (not os.path.isdir(folder) or bool(os.listdir(folder)))


def _copy(path, root, there=None):
    """Copies a file, if it is there, to the same path in the machine or to another one."""
    if os.path.isfile(path):
        target = _place(root, there or path)
        shutil.copy(path, target)


def _write(root, path, text):
    if text:
        with open(_place(root, path), "w", encoding="utf-8") as stream:
            stream.write(text)


def _place(root, path):
    """Returns where a file of the machine goes, with its folder there and no link in its place."""
    target = root + path
    os.makedirs(os.path.dirname(target), exist_ok=True)
    if os.path.lexists(target):
        os.remove(target)
    return target
