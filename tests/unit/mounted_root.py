"""Words before a command that let it start bubblewrap, also below a chroot.

bubblewrap asks for a / that is a mount, which that of chroot(8) is not, and the kernel makes no
namespace of users below it. There the command, which needs root, gets mounts of its own, with the
same folder as /, by pivot_root(8); nothing outside stays in reach.
"""

import pathlib

PIVOT = 'mount --rbind . . && cd "$PWD" && pivot_root . . && umount -l . && cd "$0" && exec "$@"'
FROM_CHROOT = ["nsenter", "--mount=/proc/self/ns/mnt", "--wd=/", "unshare", "--mount", "sh", "-c"]


def words(folder):
    """Returns them.

    Args:
        folder: That the command works in.
    """
    mounts = pathlib.Path("/proc/self/mountinfo").read_text().splitlines()
    if any(line.split()[4] == "/" for line in mounts):
        return []
    return [*FROM_CHROOT, PIVOT, str(folder)]
