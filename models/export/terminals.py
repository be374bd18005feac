"""terminalsAndIcons.xml: which variables are connected together, and the icon's place."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from stickslip.models.export import xml
from stickslip.models.export.description import Model

_TILE = {"x1": 0.0, "y1": 0.0, "x2": 100.0, "y2": 100.0}


def terminals_and_icons(model: Model) -> str:
    """Return the XML; members of the same name fit each other.

    Source
    ------
    FMI 3.0.2, section 2.6; FMI 2.0.4 takes the same file.
    """
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = xml.child(root, "GraphicalRepresentation")
    xml.child(picture, "CoordinateSystem", **_TILE, suggestedScalingFactorTo_mm=0.1)
    xml.child(picture, "Icon", **_TILE)
    if model.terminals:
        section = xml.child(root, "Terminals")
        for name, terminal in model.terminals.items():
            element = xml.child(
                section,
                "Terminal",
                name=name,
                matchingRule="plug",
                description=terminal.description,
            )
            for member, variable in terminal.members.items():
                xml.child(
                    element,
                    "TerminalMemberVariable",
                    variableName=variable,
                    memberName=member,
                    variableKind="signal",
                )
    return xml.document(root)
