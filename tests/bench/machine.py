"""What the figures were measured on."""

import os
import pathlib
import platform
import re
import subprocess


def processor():
    """The processor's name and what of its vector instructions matters."""
    text = pathlib.Path("/proc/cpuinfo").read_text(errors="replace")
    name = re.search(r"^(?:model name|Model)\s*:\s*(.*)$", text, re.M)
    flags = re.search(r"^(?:flags|Features)\s*:\s*(.*)$", text, re.M)
    known = {"sse4_2", "avx2", "avx512f", "avx512_bf16", "asimd", "sve"}
    return {"name": name.group(1).strip() if name else platform.machine(),
            "vector": sorted(known & set(flags.group(1).split() if flags
                                         else ()))}


def caches():
    """Size of each cache of the first processor, as the kernel says it."""
    sizes = {}
    root = pathlib.Path("/sys/devices/system/cpu/cpu0/cache")
    for index in sorted(root.glob("index*")):
        try:
            level = (index / "level").read_text().strip()
            kind = (index / "type").read_text().strip()
            size = (index / "size").read_text().strip()
        except OSError:
            continue
        sizes[f"L{level} {kind.lower()}"] = size
    return sizes


def memory_mib():
    for line in pathlib.Path("/proc/meminfo").read_text().splitlines():
        if line.startswith("MemTotal:"):
            return int(line.split()[1]) // 1024
    return 0


def git(root, *arguments):
    done = subprocess.run(["git", "-C", str(root), *arguments], text=True,
                          capture_output=True, check=False)
    return done.stdout.strip() if done.returncode == 0 else ""


def facts(root, preset):
    """Everything that figures depend on beside the sources."""
    return {
        "processor": processor(),
        "processors": len(os.sched_getaffinity(0)),
        "caches": caches(),
        "memory_mib": memory_mib(),
        "kernel": platform.release(),
        "preset": preset,
        "commit": git(root, "rev-parse", "--short=12", "HEAD"),
        "is_modified": bool(git(root, "status", "--porcelain")),
        # Others that compute now make every figure worse.
        "load_before": round(os.getloadavg()[0], 2),
    }


def is_comparable(now, before):
    """Whether two runs were made on machines of one kind, built alike."""
    same = ("processor", "processors", "memory_mib", "preset")
    return all(now.get(name) == before.get(name) for name in same)
