# SPDX-License-Identifier: GPL-3.0-or-later
"""A reader of netCDF's classic and 64-bit offset files, from the description of the format (NetCDF Classic Format Specification), so that
files are not read by the library that wrote them."""
from running import np

TYPES = {1: ">i1", 2: "S1", 3: ">i2", 4: ">i4", 5: ">f4", 6: ">f8"}


class Bytes:
    def __init__(self, data):
        self.data, self.at = data, 0

    def integer(self, size=4):
        self.at += size
        return int.from_bytes(self.data[self.at - size:self.at], "big")

    def padded(self, n):
        start, self.at = self.at, self.at + n + (-n) % 4
        assert self.at <= len(self.data), "cut off"
        return self.data[start:start + n]

    def text(self):
        return self.padded(self.integer()).decode()

    def table(self, tag, entry):
        found, n = self.integer(), self.integer()
        assert found in (0, tag), (found, tag)
        return [entry() for _ in range(n)]

    def attribute(self):
        name, kind, n = self.text(), np.dtype(TYPES[self.integer()]), self.integer()
        values = self.padded(n * kind.itemsize)
        return name, values.decode() if kind.char == "S" else np.frombuffer(values, kind)


class Netcdf:
    """dimensions: name -> length, attributes, and variables by name: arrays in the machine's byte order."""

    def __init__(self, path):
        self._bytes = file = Bytes(path.read_bytes())
        assert file.padded(4) in (b"CDF\1", b"CDF\2"), path
        offset_size = 8 if file.data[3] == 2 else 4
        self.n_records = file.integer()
        dimensions = file.table(10, lambda: (file.text(), file.integer()))
        self.dimensions = dict(dimensions)
        self.attributes = dict(file.table(12, file.attribute))
        self._variables = {}

        def variable():
            name = file.text()
            shape = [dimensions[file.integer()] for _ in range(file.integer())]
            attributes = dict(file.table(12, file.attribute))
            kind = np.dtype(TYPES[file.integer()])
            size, start = file.integer(), file.integer(offset_size)
            self._variables[name] = (shape, attributes, kind, size, start)

        file.table(11, variable)
        self._record = sum(v[3] for v in self._variables.values() if v[0] and v[0][0][1] == 0)

    def names(self):
        return list(self._variables)

    def dimensions_of(self, name):
        return [dimension for dimension, _ in self._variables[name][0]]

    def attributes_of(self, name):
        return self._variables[name][1]

    def __contains__(self, name):
        return name in self._variables

    def __getitem__(self, name):
        shape, _, kind, _, start = self._variables[name]
        lengths = [length for _, length in shape]
        is_record = bool(lengths) and lengths[0] == 0
        inner = lengths[1:] if is_record else lengths
        n = int(np.prod(inner, dtype=np.int64))
        parts = [np.frombuffer(self._bytes.data, kind, n, start + i * self._record) for i in range(self.n_records if is_record else 1)]
        values = np.concatenate(parts) if parts else np.zeros(0, kind)
        values = values.reshape([self.n_records, *inner] if is_record else inner)
        return values if kind.char == "S" else values.astype(kind.newbyteorder("="))

    def strings(self, name):
        return [b"".join(row).split(b"\0")[0].decode().rstrip() for row in self[name]]
