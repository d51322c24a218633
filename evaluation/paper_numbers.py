"""The paper's own figures, read off its tables. Ratios are as it has them: 16 bytes a point for bytes as they are, 12 for images."""

# Table "existing compression methods": ratio, PSNR dB, CD as printed (m2 times 100), ms on the desktop and on the Jetson AGX, J.
EXISTING = {
    "RLE": {"ratio": 0.54, "psnr_db": None, "cd_printed": None, "encode_ms": (40.1, 42.4), "decode_ms": (17.9, 15.8), "encode_j": (1.18, 0.11), "decode_j": (0.51, 0.04)},
    "LZ77": {"ratio": 1.67, "psnr_db": None, "cd_printed": None, "encode_ms": (40.5, 75.4), "decode_ms": (13.8, 33.7), "encode_j": (1.19, 0.23), "decode_j": (0.39, 0.08)},
    "Draco": {"ratio": 17.05, "psnr_db": 67.29, "cd_printed": 0.267, "encode_ms": (21.1, 48.4), "decode_ms": (9.44, 18.6), "encode_j": (0.83, 0.14), "decode_j": (0.36, 0.05)},
    "G-PCC": {"ratio": 8.76, "psnr_db": 78.43, "cd_printed": 0.184, "encode_ms": (598, 741), "decode_ms": (204, 265), "encode_j": (15.35, 2.41), "decode_j": (5.56, 0.66)},
    "PCL": {"ratio": 5.72, "psnr_db": 89.77, "cd_printed": 0.001, "encode_ms": (72.1, 198), "decode_ms": (55.4, 153), "encode_j": (2.05, 0.46), "decode_j": (1.54, 0.36)},
    "RT-ST": {"ratio": 15.96, "psnr_db": 63.18, "cd_printed": 3.07, "encode_ms": (97.7, 240), "decode_ms": (15.2, 34.8), "encode_j": (2.63, 0.59), "decode_j": (0.57, 0.12)},
}

# Table "latencies of each IR construction", ms.
CONSTRUCTION = {
    "desktop": {"range image": 11.78, "range image, parallel": 6.72, "octree": 30.67, "k-d tree": 13.21, "mesh": 1872},
    "Jetson": {"range image": 16.34, "range image, parallel": 9.26, "octree": 32.11, "k-d tree": 32.44, "mesh": 2755},
}

# Table "H.264 with different QPs".
H264 = {
    0: {"ratio": 12.85, "psnr_db": 63.18, "cd_printed": 2.23},
    10: {"ratio": 13.33, "psnr_db": 48.21, "cd_printed": 16.25},
    20: {"ratio": 16.41, "psnr_db": 37.61, "cd_printed": 126.06},
    30: {"ratio": 35.01, "psnr_db": 38.12, "cd_printed": 107.16},
}

# Tables "existing quality metrics with sampling error" and "comparison between Draco and FLiCR"; ms and J: desktop, Jetson.
WIDTHS = {
    4500: {"ratio": 21.26, "se": 0.084, "psnr_db": 63.18, "epsnr_db": 63.13, "cd_printed": None, "encode_ms": (10.48, 26.83), "decode_ms": (12.52, 21.94), "encode_j": (0.36, 0.09), "decode_j": (0.48, 0.05)},
    4096: {"ratio": 24.75, "se": 0.091, "psnr_db": 63.09, "epsnr_db": 63.01, "cd_printed": None, "encode_ms": (7.69, 23.41), "decode_ms": (7.44, 20.97), "encode_j": (0.27, 0.07), "decode_j": (0.3, 0.05)},
    2048: {"ratio": 46.18, "se": 0.2103, "psnr_db": 62.4, "epsnr_db": 61.64, "cd_printed": 5.37, "encode_ms": (4.3, 16.03), "decode_ms": (4.67, 17.09), "encode_j": (0.16, 0.04), "decode_j": (0.19, 0.04)},
    1024: {"ratio": 80.88, "se": 0.5877, "psnr_db": 61.41, "epsnr_db": 51.38, "cd_printed": 9.23, "encode_ms": (3.37, 12.26), "decode_ms": (2.47, 15.13), "encode_j": (0.13, 0.03), "decode_j": (0.13, 0.04)},
    512: {"ratio": 131.13, "se": 0.7895, "psnr_db": 58.61, "epsnr_db": 35.4, "cd_printed": 15.22, "encode_ms": (2.35, 10.46), "decode_ms": (2.01, 11.06), "encode_j": (0.09, 0.03), "decode_j": (0.09, 0.03)},
    256: {"ratio": 215.85, "se": 0.8922, "psnr_db": 53.71, "epsnr_db": 22.29, "cd_printed": 36.17, "encode_ms": (1.99, 9.54), "decode_ms": (1.36, 10.11), "encode_j": (0.07, 0.02), "decode_j": (0.08, 0.02)},
}

# Section "challenges": mean average precision left after so many ms of discrepancy, shares of the one without.
DISCREPANCY = {30: 0.72, 100: 0.5}
