"""Time and memory over the size of a graph, as SVG. Nothing is measured here."""
import math

PANEL_W, PANEL_H = 320, 250
LEFT, GAP, TOP, LOW, RIGHT = 70, 92, 44, 52, 20
INK, FAINT, GRID, FINE = "#1f2937", "#5b6675", "#d8dde5", "#eef1f5"


def decades(values):
    """Powers of ten that hold all values."""
    return math.floor(math.log10(min(values)) + 1e-9), math.ceil(math.log10(max(values)) - 1e-9)


def power_text(power):
    return f"{10 ** power:,}" if power >= 0 else f"{10.0 ** power:g}"


class Panel:
    """Axes in powers of ten; x spans are shared by the caller, y spans are the data's."""

    def __init__(self, left, xs, ys):
        self.left = left
        self.x_low, self.x_high = math.log10(min(xs)) - 0.12, math.log10(max(xs)) + 0.12
        self.y_low, self.y_high = decades(ys)

    def x(self, value):
        return self.left + (math.log10(value) - self.x_low) / (self.x_high - self.x_low) * PANEL_W

    def y(self, value):
        return TOP + (self.y_high - math.log10(value)) / (self.y_high - self.y_low) * PANEL_H

    def in_x(self, value):
        return self.x_low <= math.log10(value) <= self.x_high

    def axes(self, title, ticks):
        right, bottom = self.left + PANEL_W, TOP + PANEL_H
        out = [
            f'<text x="{self.left}" y="{TOP - 18}" fill="{INK}" font-size="13"'
            f' font-weight="bold">{title}</text>'
        ]
        for power in range(self.y_low, self.y_high + 1):
            y = self.y(10.0**power)
            if power < self.y_high:
                fine = "".join(
                    f"M{self.left} {self.y(k * 10.0 ** power):.1f}H{right}" for k in range(2, 10)
                )
                out.append(f'<path d="{fine}" stroke="{FINE}" fill="none"/>')
            out += [
                f'<path d="M{self.left} {y:.1f}H{right}" stroke="{GRID}" fill="none"/>',
                (
                    f'<text x="{self.left - 8}" y="{y + 4:.1f}" text-anchor="end"'
                    f' fill="{FAINT}">{power_text(power)}</text>'
                ),
            ]
        for tick in filter(self.in_x, ticks):
            x = self.x(tick)
            out += [
                f'<path d="M{x:.1f} {TOP}V{bottom}" stroke="{GRID}" fill="none"/>',
                (
                    f'<text x="{x:.1f}" y="{bottom + 18}" text-anchor="middle"'
                    f' fill="{FAINT}">{tick:,}</text>'
                ),
            ]
        return out + [
            f'<path d="M{self.left} {TOP}V{bottom}H{right}" stroke="{FAINT}" fill="none"/>',
            (
                f'<text x="{self.left + PANEL_W / 2}" y="{bottom + 40}" text-anchor="middle"'
                f' fill="{INK}">poses</text>'
            ),
        ]

    def line(self, points, colour, style=""):
        path = " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in points)
        return (
            f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.8"{style}/>'
        )

    def dots(self, points, colour):
        return [
            f'<circle cx="{self.x(a):.1f}" cy="{self.y(b):.1f}" r="4.2" fill="{colour}"'
            ' stroke="#ffffff"/>'
            for a, b in points
        ]


def panel(left, title, points, fit, colour, ticks):
    """Measured points, and the power law through those that it was fitted to."""
    axes = Panel(left, [a for a, _ in points], [b for _, b in points])
    ends = [(a, fit.at(a)) for a in (fit.first, fit.last)]
    label_x, label_y = axes.x(fit.first), axes.y(fit.at(fit.first))
    return [
        *axes.axes(title, ticks),
        axes.line(points, colour, ' stroke-opacity="0.25"'),
        axes.line(ends, INK, ' stroke-dasharray="6 4" stroke-opacity="0.8"'),
        *axes.dots(points, colour),
        (
            f'<text x="{label_x + 24:.1f}" y="{label_y + 24:.1f}" fill="{INK}">~ poses'
            f'<tspan dy="-5" font-size="9.5">{fit.exponent:.2f}</tspan></text>'
        ),
    ]


def scaling_picture(panels, ticks=(1000, 10000, 100000)):
    """Panels side by side: (title, points, fit, colour) each."""
    width = LEFT + len(panels) * PANEL_W + (len(panels) - 1) * GAP + RIGHT
    height = TOP + PANEL_H + LOW
    out = [
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"'
            f' width="{width}" height="{height}" font-family="DejaVu Sans, sans-serif"'
            ' font-size="12" role="img" aria-label="Time of a step and peak memory over the number'
            ' of poses">'
        ),
        '<rect width="100%" height="100%" fill="#ffffff"/>',
    ]
    for i, (title, points, fit, colour) in enumerate(panels):
        out += panel(LEFT + i * (PANEL_W + GAP), title, points, fit, colour, ticks)
    return "\n".join([*out, "</svg>", ""])
