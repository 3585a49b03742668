"""What machines of a fleet tell each other: `keys` has the table, `codec` the form, and every kind its own small file.

A new kind is one file here: a dataclass as the program knows it, a `msgspec.Struct` as it travels, and a `Kind` of both.
"""
