"""Re-does the FLiCR paper's tables and figures, beside other systems: `make paper`.

    scans.py          the scans that are measured
    configurations.py every system and setting
    program.py        the `flicr` program; rivals.py: other systems
    store.py          results by the hash of all that they depend on, so that a run resumes
    run.py            what a section asks for: decoded clouds, quality, times
    sections/         one file a section of the report; the list is in sections/__init__.py
    perception.py     the tasks on original and decoded clouds: odometry.py, pointgnn/; metric_fit.py: metrics against them
    report.py         tables, plots and text; page.py: the one HTML file made of them
"""
