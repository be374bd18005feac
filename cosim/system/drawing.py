"""A system as a block diagram in SVG: columns from inputs to outputs, feedback below."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, zip_longest

from stickslip.fmi.messages import escaped

Port = tuple[str, str]
"""Component and variable; of what the system exposes, no component and the name."""
Wire = tuple[Port, Port]  # source and target
_ROW, _HEAD, _LETTER = 15, 34, 6.4  # height of a port and of a title, width of a letter [px]
_GAP, _APART, _MARGIN, _LANE = 70, 22, 12, 12  # between columns, boxes, and lanes of feedback
_SWEEPS = 4
_LOOK = 'font-family="sans-serif" font-size="11" stroke="currentColor" fill="none" stroke-width="1"'


@dataclass
class _Box:
    """A component, an exposed name, or the place where a wire passes across a column."""

    title: str = ""
    note: str = ""
    inputs: list[str] = field(default_factory=list)
    outputs: list[str] = field(default_factory=list)
    x: float = 0.0
    y: float = 0.0
    across: float = 0.0

    @property
    def width(self) -> float:
        rows = zip_longest(self.inputs, self.outputs, fillvalue="")
        words = [self.title, self.note, *map("".join, rows)]
        return max(len(one) for one in words) * _LETTER + 24 if self.title else self.across

    @property
    def height(self) -> float:
        rows = max(len(self.inputs), len(self.outputs))
        return _HEAD + _ROW * rows + 4 if self.title and rows else 20.0 if self.title else 4.0

    def port(self, name: str, *, leaves: bool) -> tuple[float, float]:
        names = self.outputs if leaves else self.inputs
        offset = _HEAD + _ROW * (names.index(name) + 0.4) if name in names else self.height / 2
        return self.x + self.width * leaves, self.y + offset


def block_diagram(components: Mapping[str, str], wires: Sequence[Wire]) -> str:
    """Return the diagram as an SVG element; ``components`` has what stands below each name."""
    boxes = {f"> {port}": _Box(port) for (name, port), _ in wires if not name}
    boxes |= {name: _Box(name, note) for name, note in components.items()}
    boxes |= {f"< {port}": _Box(port) for _, (name, port) in wires if not name}
    ends = [(begin[0] or f"> {begin[1]}", end[0] or f"< {end[1]}") for begin, end in wires]
    for ((_, source), (_, target)), (begin, end) in zip(wires, ends, strict=True):
        for names, port in ((boxes[begin].outputs, source), (boxes[end].inputs, target)):
            names += [port] if port not in names else []
    for name in boxes.keys() - components.keys():
        boxes[name].inputs, boxes[name].outputs = [], []
    column = _columns(list(boxes), ends)
    drawn: list[tuple[Wire, list[str]]] = []
    back: list[tuple[Wire, list[str]]] = []
    for wire, (begin, end) in zip(wires, ends, strict=True):
        path = [begin]
        for place in range(column[begin] + 1, column[end]):
            boxes[name := f"\0{len(boxes)}"] = _Box()
            column[name] = place
            path.append(name)
        (drawn if column[end] > column[begin] else back).append((wire, [*path, end]))
    width, height = _placed(boxes, column, [pair for _, path in drawn for pair in pairwise(path)])
    lines = [_forward(boxes, wire, path) for wire, path in drawn]
    for lane, (wire, path) in enumerate(back):
        lines.append(_feedback(boxes, wire, path, height + _LANE * lane, lane))
    height += _LANE * len(back)
    shown = [_drawn(box) for box in boxes.values() if box.title]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}"'
    head += f' width="{width:g}" style="max-width:100%" {_LOOK}>'
    return "\n".join([head, "\n".join([*lines, *shown]), "</svg>"])


def _columns(names: Sequence[str], ends: Sequence[tuple[str, str]]) -> dict[str, int]:
    """Return the column of each box: one behind the last of those it follows, but for feedback."""
    after: dict[str, list[str]] = {name: [] for name in names}
    for begin, end in ends:
        if begin != end:
            after[begin].append(end)
    order: list[str] = []
    state: dict[str, int] = {}

    def visit(name: str) -> None:
        state[name] = 1
        for follower in list(after[name]):
            if state.get(follower) == 1:
                after[name].remove(follower)  # feedback
            elif follower not in state:
                visit(follower)
        state[name] = 2
        order.append(name)

    for name in names:
        if name not in state:
            visit(name)
    column = dict.fromkeys(names, 0)
    for name in reversed(order):
        for follower in after[name]:
            column[follower] = max(column[follower], column[name] + 1)
    return column


def _placed(
    boxes: Mapping[str, _Box], column: Mapping[str, int], pairs: Sequence[tuple[str, str]]
) -> tuple[float, float]:
    """Place the boxes so that wires cross little; return width and height of the diagram."""
    stacks: list[list[str]] = [[] for _ in range(max(column.values(), default=0) + 1)]
    for name, place in column.items():
        stacks[place].append(name)

    def stacked() -> float:
        x = lowest = float(_MARGIN)
        for names in stacks:
            widest, y = max((boxes[name].width for name in names), default=0.0), float(_MARGIN)
            for name in names:
                boxes[name].x, boxes[name].y, boxes[name].across = x, y, widest
                y += boxes[name].height + _APART
            x += widest + _GAP
            lowest = max(lowest, y)
        for names in filter(None, stacks):
            below = boxes[names[-1]]
            shift = (lowest - (below.y + below.height + _APART)) / 2
            for name in names:
                boxes[name].y += shift
        return lowest

    def middle(name: str) -> float:
        beside = [a if b == name else b for a, b in pairs if name in (a, b)]
        heights = [boxes[one].y + boxes[one].height / 2 for one in beside or [name]]
        return sum(heights) / len(heights)

    height = stacked()
    for _ in range(_SWEEPS):
        for names in stacks:
            names.sort(key=middle)
        height = stacked()
    right = max((box.x + box.width for box in boxes.values()), default=0.0)
    return right + _MARGIN + _LANE, height


def _forward(boxes: Mapping[str, _Box], wire: Wire, path: Sequence[str]) -> str:
    (_, source), (_, target) = wire
    x, y = boxes[path[0]].port(source, leaves=True)
    line = f"M{x:g} {y:g}"
    for name in path[1:]:
        to_x, to_y = boxes[name].port(target if name == path[-1] else "", leaves=False)
        bend = (to_x + x) / 2
        line += f"C{bend:g} {y:g} {bend:g} {to_y:g} {to_x:g} {to_y:g}"
        x, y = to_x, to_y
        if name != path[-1]:
            x += boxes[name].width
            line += f"H{x:g}"
    return _path(line, (x, y), wire)


def _feedback(
    boxes: Mapping[str, _Box], wire: Wire, path: Sequence[str], y: float, lane: int
) -> str:
    (_, source), (_, target) = wire
    x, begin = boxes[path[0]].port(source, leaves=True)
    to_x, end = boxes[path[-1]].port(target, leaves=False)
    out, into = x + 12 + 5 * lane, to_x - 12 - 5 * lane
    return _path(f"M{x:g} {begin:g}H{out:g}V{y:g}H{into:g}V{end:g}H{to_x:g}", (to_x, end), wire)


def _path(line: str, tip: tuple[float, float], wire: Wire) -> str:
    label = escaped(" to ".join(".".join(filter(None, port)) for port in wire))
    head = f'<path d="M{tip[0]:g} {tip[1]:g}l-7 -3v6z" fill="currentColor" stroke="none"/>'
    return f'<path d="{line}"><title>{label}</title></path>{head}'


def _drawn(box: _Box) -> str:
    x, y, width = box.x, box.y, box.width
    words = [(x + width / 2, y + 14, "middle", 'font-weight="bold"', box.title)]
    if box.note:
        words.append((x + width / 2, y + 27, "middle", 'opacity="0.7"', box.note))
    words += [(x + 6, box.port(n, leaves=False)[1] + 4, "start", "", n) for n in box.inputs]
    words += [(x + width - 6, box.port(n, leaves=True)[1] + 4, "end", "", n) for n in box.outputs]
    outline = f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{box.height:g}" rx="3"/>'
    return outline + "".join(
        f'<text x="{at:g}" y="{level:g}" text-anchor="{anchor}" {look} fill="currentColor"'
        f' stroke="none">{escaped(text)}</text>'
        for at, level, anchor, look, text in words
    )
