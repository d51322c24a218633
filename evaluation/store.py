"""Results by what they depend on: a JSON file for each, so that a run that ended early resumes where it was."""

import hashlib
import json
import os
import tempfile
from functools import lru_cache
from pathlib import Path


def digest(*parts):
    """16 hexadecimal digits of anything that JSON can hold; files by `file_digest`."""
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


@lru_cache(maxsize=None)
def _digest_of(path, size, time_ns):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16]


def file_digest(path):
    """Of a file's contents; read again only where size or time changed."""
    stat = os.stat(path)
    return _digest_of(str(path), stat.st_size, stat.st_mtime_ns)


def source_digest(*modules):
    """Of Python modules' sources: part of a key where code makes the result."""
    return digest(*(file_digest(module.__file__) for module in modules))


def write_whole(path, text):
    """A file that is there whole or not at all."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".part-")
    with os.fdopen(handle, "w", encoding="utf-8") as out:
        out.write(text)
    os.chmod(temporary, 0o644)
    os.replace(temporary, path)


class Store:
    """Under one folder: `KIND/KEY.json` results and, beside them, whatever files they need."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.computed = 0
        self.found = 0

    def get(self, kind, key, compute):
        """The result of `compute()` (anything that JSON holds), or what it was when `key` was the same.

        `key` is a list of what the result depends on. An exception is not kept.
        """
        path = self.folder / kind / f"{digest(key)}.json"
        try:
            result = json.loads(path.read_text(encoding="utf-8"))["result"]
            self.found += 1
            return result
        except (FileNotFoundError, json.JSONDecodeError, KeyError):
            pass
        result = compute()
        write_whole(path, json.dumps({"key": key, "result": result}, default=str) + "\n")
        self.computed += 1
        return result

    def file(self, kind, key, suffix, make):
        """The path of a file that `make(path)` writes, kept likewise."""
        path = self.folder / kind / f"{digest(key)}{suffix}"
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            part = path.with_name(f".part-{os.getpid()}-{path.name}")
            try:
                make(part)
                os.replace(part, path)
            finally:
                part.unlink(missing_ok=True)
        return path
