# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of materials, numbered stripes and the library of assets, in German."""

PRESETS = {
    "Material Presets": "Material-Vorgaben",
    "Materials in one click": "Materialien mit einem Klick",
    "Apply Preset": "Vorgabe anwenden",
    "Show a preset on the active object; where its pattern cannot, one is solved for it": (
        "Eine Vorgabe auf dem aktiven Objekt zeigen; passt sein Muster nicht, wird eines dafür gelöst"
    ),
    "Preset": "Vorgabe",
    "What the object looks like": "Wie das Objekt aussieht",
    "Solve": "Lösen",
    "Solve the pattern that the preset is made for, also where the object has one that can show it": (
        "Das Muster lösen, für das die Vorgabe gemacht ist, auch wenn das vorhandene sie zeigen kann"
    ),
    "Solved for": "Gelöst für",
    "Zebra": "Zebra",
    "Black and white hair, bold stripes with frayed edges": "Schwarz-weißes Fell, kräftige Streifen mit fransigem Rand",
    "Corduroy": "Cord",
    "Ribs of velvet, worn on top": "Samtrippen, oben abgewetzt",
    "Wood-Cut": "Holzschnitt",
    "Lines of ink along the least curvature, which swell where the surface is turned from the light": (
        "Tuschelinien entlang der kleinsten Krümmung, die dem Licht abgewandt anschwellen"
    ),
    "Knit Ribs": "Strickrippen",
    "Columns of stitches of a thick yarn": "Maschenreihen aus dickem Garn",
    "Woven Cane": "Rattangeflecht",
    "Strips of rattan, over and under in turn": "Rattanstreifen, abwechselnd über- und untereinander",
    "Fingerprint": "Fingerabdruck",
    "Ridges in ink, which break off and have pores": "Rillen in Tinte, die abreißen und Poren haben",
    "Number Stripes": "Streifen nummerieren",
    "Give each stripe of the last solve a number, and its points a place along it, for materials and relief": (
        "Jedem Streifen der letzten Lösung eine Nummer und seinen Punkten einen Ort auf ihm geben, für Materialien"
    ),
    "Add Asset Library": "Asset-Bibliothek hinzufügen",
    "List the library of presets and node groups that comes with the extension in the preferences": (
        "Die Bibliothek der Vorgaben und Node-Gruppen, die mit der Erweiterung kommt, in den Einstellungen aufführen"
    ),
    "{name} has no stripes: solve them first": "{name} hat keine Streifen: lösen Sie diese zuerst",
}
