"""A line chart with logarithmic axes, as SVG."""

import math

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 900, 400, 70, 20, 360, 50
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#444444", "#999999"]


def text(x, y, words, anchor="middle"):
    words = words.replace("&", "&amp;").replace("<", "&lt;")
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{words}</text>'


def axis(values):
    return math.log10(min(values)) - 0.05, math.log10(max(values)) + 0.05


def chart(series, x_title, y_title, x_ticks):
    """`series`: name to points (x, y), all positive; a name that ends with * is drawn dashed."""
    points = [point for line in series.values() for point in line]
    x_low, x_high = axis([x for x, _ in points])
    y_low, y_high = axis([y for _, y in points])
    right, low = WIDTH - RIGHT, HEIGHT - BOTTOM

    def at(x, y):
        return (LEFT + (math.log10(x) - x_low) / (x_high - x_low) * (right - LEFT),
                low - (math.log10(y) - y_low) / (y_high - y_low) * (low - TOP))

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
             'font-family="sans-serif" font-size="13">',
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']
    for x, name in x_ticks.items():
        px = at(x, points[0][1])[0]
        parts += [f'<path d="M{px:.1f} {TOP}V{low}" stroke="#ddd"/>', text(px, low + 18, name)]
    for power in range(math.ceil(y_low), math.floor(y_high) + 1):
        py = at(points[0][0], 10.0 ** power)[1]
        parts += [f'<path d="M{LEFT} {py:.1f}H{right}" stroke="#ddd"/>',
                  text(LEFT - 6, py + 4, f"1e{power}", "end")]
    for i, (name, line) in enumerate(series.items()):
        colour = COLOURS[i % len(COLOURS)]
        dash = ' stroke-dasharray="6 4"' if name.endswith("*") else ""
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in (at(*p) for p in line))
        y = TOP + 14 + 22 * i
        parts.append(f'<polyline points="{path}" fill="none" stroke="{colour}" '
                     f'stroke-width="2"{dash}/>')
        if not dash:
            parts += [f'<circle cx="{px:.1f}" cy="{py:.1f}" r="3.5" fill="{colour}"/>'
                      for px, py in (at(*p) for p in line)]
        parts += [f'<path d="M{right + 14} {y - 4}h24" stroke="{colour}" stroke-width="2"{dash}/>',
                  text(right + 44, y, name.rstrip("*"), "start")]
    parts += [f'<path d="M{LEFT} {TOP}V{low}H{right}" fill="none" stroke="#444"/>',
              text((LEFT + right) / 2, HEIGHT - 8, x_title),
              f'<g transform="translate(16 {(TOP + low) / 2}) rotate(-90)">',
              text(0, 0, y_title), "</g>", "</svg>"]
    return "\n".join(parts) + "\n"
