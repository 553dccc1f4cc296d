"""Runs: missing blocks are computed and kept in a journal, then the file is written from all blocks and published."""
