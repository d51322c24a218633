"""Discrepancy latency: what a result is late by when the cloud goes over a link."""

from .. import paper_numbers
from ..configurations import group
from ..figures import figure, look, medians, milliseconds
from ..report import Section

# Name, uplink in Mbit/s, round trip in ms: assumed, typical of what a moving device gets.
LINKS = (("5G", 60.0, 20.0), ("LTE", 12.0, 50.0), ("Wi-Fi", 80.0, 5.0), ("1 Mbit radio", 1.0, 40.0))
# The paper's Jetson takes so many times its desktop's time to encode: Draco 48.4 / 21.1, FLiCR 26.83 / 10.48.
SLOWER = 2.4
SCAN_INTERVAL_MS = 100.0
# Results that a task can use: fewer points or coarser than this is another kind of cloud (section of the tasks).
USABLE_LOST = 0.25
RAW = "raw points, 16 B each"


def section(run):
    made = Section("links", "Discrepancy latency")
    configurations = [c for c in group("links") if not run.quick or c.is_in("quick")]
    quality = run.measured(configurations, label="links")
    times = run.times([c for c in configurations if c.name in quality], "links")
    measured = {}
    for configuration in configurations:
        encode, decode = (milliseconds(times.get(configuration.name), side) for side in ("encode", "decode"))
        if encode is not None and decode is not None and configuration.name in quality:
            m = medians(quality[configuration.name])
            measured[configuration.name] = (configuration, m, encode, decode)
    if not measured:
        made.text("The drivers that time encoding and decoding are not built on this machine: no latency can be told.")
        return made
    points = run.scans[0].points
    rows = [[RAW, 16 * points, 0.0, "lossless", *latencies(0.0, 16 * points, 0.0)]]
    for configuration, m, encode, decode in measured.values():
        rows.append([configuration.label, m["bytes"], percent(m["se"]), m["psnr_db"] if m["cd_m2"] else "lossless",
                     *latencies(SLOWER * encode, m["bytes"], decode)])
        made.numbers[configuration.name] = {name: value for (name, _, _), value in zip(LINKS, latencies(SLOWER * encode, m["bytes"], decode))}
    made.text(
        "How old the server’s cloud is: encoding on the device, the frame over the link, half a round trip, decoding on the server. The paper "
        f"argues with this (its Figure 4: 30 ms cost a detector 28 % of its precision, 100 ms half). The device is taken to be {SLOWER} times slower "
        "than this machine, which is what the paper’s Jetson is to its desktop; the server is this machine. Links are assumed: "
        + "; ".join(f"{name} {rate:g} Mbit/s up, {round_trip:g} ms round trip" for name, rate, round_trip in LINKS) + ".")
    made.table("links", "Age of a cloud when the server has it, ms; in brackets, a link that cannot carry ten scans a second",
               ["configuration", "bytes", "lost %", "PSNR dB", *(name for name, _, _ in LINKS)], [[*row[:4], *map(shown, row[2 + 2:], fits(row[1]))] for row in rows],
               [None, 0, 1, 1, 1, 1, 1, 1])
    best(made, measured)
    drawn(made, measured)
    return made


def percent(share):
    return None if share is None else 100 * share


def latencies(encode_ms, coded_bytes, decode_ms):
    """For each link, ms."""
    return [encode_ms + 8e-3 * coded_bytes / rate + round_trip / 2 + decode_ms for _, rate, round_trip in LINKS]


def fits(coded_bytes):
    """For each link, whether a frame is through before the next scan is there."""
    return [8e-3 * coded_bytes / rate <= SCAN_INTERVAL_MS for _, rate, _ in LINKS]


def shown(value, is_fitting):
    text = f"{value:,.1f}" if value < 1000 else f"{value:,.0f}"
    return text if is_fitting else f"({text})"


def best(made, measured):
    """The youngest cloud on each link that loses few points, and of any kind; only of what the link carries."""
    rows = []
    for index, (name, rate, round_trip) in enumerate(LINKS):
        age = {key: latencies(SLOWER * e, m["bytes"], d)[index] for key, (_, m, e, d) in measured.items() if fits(m["bytes"])[index]}
        usable = {key: value for key, value in age.items() if (measured[key][1]["se"] or 0.0) <= USABLE_LOST and not measured[key][1]["se"] is None}
        for kind, candidates in (("no point in four lost", usable), ("any", age)):
            if candidates:
                key = min(candidates, key=candidates.get)
                configuration, m, _, _ = measured[key]
                rows.append([name, kind, configuration.label, candidates[key], m["bytes"], percent(m["se"]), m["psnr_db"]])
                made.numbers.setdefault("best", {})[f"{name}, {kind}"] = {"ms": candidates[key], "bytes": m["bytes"], "se": m["se"], "psnr_db": m["psnr_db"]}
            else:
                rows.append([name, kind, "none that it carries", None, None, None, None])
    made.table("best_on_link", "The youngest cloud on each link", ["link", "among", "configuration", "ms", "bytes", "lost %", "PSNR dB"], rows,
               [None, None, None, 1, 0, 1, 1])
    made.text("On fast links what counts is time on the processor, on slow ones bytes: the fast tier is for the former, the dense tier and coarse "
              "steps for the latter. Everything is a frame at a time here; strips (docs/PERFORMANCE.md, Streams) send a turn while the sensor "
              "still makes it, and are not counted.")


def drawn(made, measured):
    rates = [10 ** (exponent / 20) for exponent in range(-10, 45)]
    fig, axes = figure(9, 5)
    wanted = [key for key in ("authors-4500", "draco-qp11", "cloudini-20mm", "laszip-10mm", "dense-20mm", "fast-20mm", "dense-102mm", "dense-314mm", "uniform-4500", "uniform-256")
              if key in measured]
    for key in wanted:
        configuration, m, encode, decode = measured[key]
        color, _ = look(configuration.system)
        style = ":" if key.endswith("314mm") or key.endswith("256") else "--" if key.endswith("102mm") else "-"
        axes.plot(rates, [SLOWER * encode + 8e-3 * m["bytes"] / rate + decode for rate in rates], style, color=color, label=configuration.label,
                  linewidth=2.4 if configuration.is_ours else 1.3)
    for name, rate, _ in LINKS:
        axes.axvline(rate, color="#ced4da", linewidth=0.8)
        axes.text(rate, 1.01, name, transform=axes.get_xaxis_transform(), ha="center", fontsize=8.5, color="#5b6675")
    axes.axhline(SCAN_INTERVAL_MS, color="#adb5bd", linestyle=":", linewidth=1)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("uplink, Mbit/s")
    axes.set_ylabel("ms, without the round trip")
    axes.legend(fontsize=8.5)
    made.plot("links_plot", "Encode, link and decode against the link’s rate (round trip left out). The dotted line is a scan’s interval.", fig)
