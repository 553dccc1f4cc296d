"""Mistakes that a type checker must find: each marked line is wrong."""

import sweep

sweep.rnu("rolling")  # wrong
sweep.run(3)  # wrong
sweep.run("rolling", threads="two")  # wrong
sweep.run("rolling", progress="yes")  # wrong
sweep.run("rolling", progress=lambda: None)  # wrong
sweep.run("rolling", progress=lambda status: status.percent)  # wrong
sweep.run_to_file("rolling")  # wrong
sweep.run("rolling").eulerdisc.stable  # xarray gives names of variables as attributes: nobody can know
sweep.open_atlas("a.nc", indexd=False)  # wrong
sweep.findings("audit.nc")  # wrong
sweep.compare(sweep.run("rolling"), sweep.run("rolling")).equal  # wrong
sweep.SweepSpec.preset(1)  # wrong
