"""Figures of programs that no registry has, measured on another machine: median over 13 KITTI scans, one x86-64 core.

Sizes and errors are the programs' own and repeat anywhere; times are that machine's. A run with FLICR_TMC3 or FLICR_RTST makes its own.
"""

MARK = "measured elsewhere"

# name: (label, system, bits a point, PSNR dB (None: exact), share of points lost, encode ms, decode ms)
FIGURES = {
    "gpcc-lossless": ("G-PCC predictive-angular, lossless at 1 mm", "G-PCC", 10.64, None, 0.0, 155, 30),
    "gpcc-r05": ("G-PCC predictive-angular, r05", "G-PCC", 6.83, 94.0, 0.0, 164, 24),
    "gpcc-r04": ("G-PCC predictive-angular, r04", "G-PCC", 4.50, 82.8, 0.0, 127, 21),
    "gpcc-r03": ("G-PCC predictive-angular, r03", "G-PCC", 3.56, 77.4, 0.0, 122, 19),
    "gpcc-r02": ("G-PCC predictive-angular, r02", "G-PCC", 2.55, 66.8, 0.0, 116, 16),
    "gpcc-r01": ("G-PCC predictive-angular, r01", "G-PCC", 1.93, 61.9, 0.0, 176, 15),
    "gpcc-octree": ("G-PCC octree, 1 cm", "G-PCC octree", 10.4, 84.0, 0.0, 137, 86),
    "rtst": ("RT-ST, 0.18 degrees, t 0.5", "RT-ST", 3.30, 60.6, 0.212, 33, 4.2),
}
