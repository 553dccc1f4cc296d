"""Texts for the fuzzer: in titles, attributes, names and words."""

#: Texts that break what is careless with them: mathematics, markup, control sequences, other scripts, length.
TEXTS = (
    "",
    "$",
    r"$\frac{\frac{\frac{1}{2}}{3}}{$",
    "{" * 5000,
    r"\x" + "$" * 1001,
    "[red]rich[/red] [link=http://x]y[/]",
    "\x1b[31mred\x1b]0;title\x07\x9b2J",
    "line\nline\r\nline\ttab\x00nul\x7f",
    "滚动的圆盘 جسم 😀 \u202egnp.exe",
    "%s %n {0} {}",
    "x" * 2**20,
    "../../../etc/passwd",
    "nan",
    "1e999",
    "\ud7ff\uffff\u2028",
)
