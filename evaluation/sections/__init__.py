"""The report's sections, in its order.

A section is a module with a function `section(run)`, which gives a `report.Section`. One that cannot be made on this
machine gives a section that says so; it does not raise.
"""

from . import (
    construction,
    detection,
    existing_methods,
    links,
    method,
    metric_fit,
    metrics_check,
    odometry,
    pictures,
    range_images,
    rate_distortion,
)

SECTIONS = (
    existing_methods,
    construction,
    range_images,
    rate_distortion,
    pictures,
    odometry,
    detection,
    metric_fit,
    links,
    metrics_check,
    method,
)
