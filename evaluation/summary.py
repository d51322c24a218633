"""The head of the report: what it is of, and what it comes to."""

import html


def heading(run, sections):
    kind = "A quick look" if run.quick else "The full run"
    numbers = {section.name: section.numbers for section in sections}
    return (
        "<h1>FLiCR, re-done</h1>"
        '<p class="lead">Every table and figure of <i>FLiCR: A Fast and Lightweight LiDAR Point Cloud Compression Based on Lossy RI</i> '
        "(Heo, Phillips, Gavrilovska, 2022), measured again beside today’s systems on one machine.</p>"
        f"<p>{kind}: {html.escape(run.origin.origin)}. Rows in italics on yellow are the paper’s own figures.</p>"
        + ('<p class="warning">The scans are simulated: sizes and errors are not those of a real street.</p>' if run.origin.simulated else "")
        + '<div class="cards">' + "".join(f'<div class="card"><b>{value}</b><span>{text}</span></div>' for value, text in cards(numbers)) + "</div>"
    )


def cards(numbers):
    """A few figures, of those sections that there are."""
    quality = {**numbers.get("existing_methods", {}), **numbers.get("rate_distortion", {})}
    fine, lossless, draco = (quality.get(name) for name in ("dense-20mm", "dense-lossless", "draco-qp14"))
    if fine:
        yield f"{fine['ratio_xyzi']:.0f} : 1", f"a scan of 16 bytes a point, none lost, the worst {1000 * fine['max_error_m']:.0f} mm off (dense, 20 mm)"
    if lossless:
        yield f"{lossless['ratio_xyzi']:.0f} : 1", "at the sensor’s own 2 mm, no range changed"
    if fine and draco:
        yield (f"{draco['bpp'] / fine['bpp']:.1f} x", f"fewer bits than Draco at like error ({draco['psnr_db']:.0f} dB; flicr {fine['psnr_db']:.0f} dB)")
    made = numbers.get("construction", {})
    if made.get("one_thread") and made.get("authors"):
        yield f"{made['authors'] / made['one_thread']:.1f} x", f"faster from points to range image than the authors’ way ({made['one_thread']:.2f} ms)"
    small = numbers.get("range_images", {}).get("boards", {}).get("m7", {}).get("256:deflate-small:120")
    if small:
        yield f"{small['encoder_bytes'] / 1024:.0f} KB", f"of RAM for a 256x64 frame on a Cortex-M7, {(small['project'] + small['code']) / 1e6:.0f} M instructions"
