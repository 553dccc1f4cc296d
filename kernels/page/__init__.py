"""The WebAssembly module of a page: entry points, and replacements of C functions."""
