# SPDX-License-Identifier: GPL-3.0-or-later
"""What is put together from parts, and why an operator cannot run, in German."""

PARTS = {
    "starting": "beginnt",
    "waiting": "wartet",
    "building": "Aufbau",
    "relaxation": "Relaxierung",
    "first field": "erstes Feld",
    "spectral relaxation": "spektrale Relaxierung",
    "continuation": "Fortsetzung",
    "polish": "Feinschliff",
    "diffusion": "Diffusion",
    "pattern": "Muster",
    "unwrap": "Abwicklung",
    "mask": "Maske",
    "height": "Höhe",
    "colour": "Farbe",
    "normal": "Normale",
    "phase": "Phase",
    "index": "Nummern",
    "write": "Schreiben",
    "{passed:.0f} s": "{passed:.0f} s",
    "{passed:.0f} s, about {left:.0f} s left": "{passed:.0f} s, noch etwa {left:.0f} s",
    "Turn the view to see a first result": "Ansicht drehen, um ein erstes Ergebnis zu sehen",
    "Esc over the 3D view: cancel": "Esc über der 3D-Ansicht: abbrechen",
    "Energy {energy:.4g}": "Energie {energy:.4g}",
    "Proved: no field saves more than {gap:.0%}": "Bewiesen: höchstens {gap:.0%} besser",
    "About {gap:.0%} above the bound": "Etwa {gap:.0%} über der Schranke",
    "Spacing × {low:.2f} to {high:.2f}, {off:.0%} off": "Abstand × {low:.2f} bis {high:.2f}, {off:.0%} daneben",
    "disclination": "Disklination",
    "disclinations": "Disklinationen",
    "dislocation": "Versetzung",
    "dislocations": "Versetzungen",
    "swirl point": "Wirbelpunkt",
    "swirl points": "Wirbelpunkte",
    "line end": "Linienende",
    "line ends": "Linienenden",
    "vertex": "Punkt",
    "vertices": "Punkte",
    "Coarse mesh: about {count} lines across": "Grobes Netz: etwa {count} Linien",
    "Coarse mesh: about one line across": "Grobes Netz: etwa eine Linie",
    "Energy 0: as even as can be": "Energie 0: so gleichmäßig wie möglich",
    "Coarse mesh: carries {spacing}": "Grobes Netz: trägt {spacing}",
    "Subdivide to {count:,} Faces": "In {count:,} Flächen unterteilen",
    "Select Defects": "Defekte wählen",
    "select other meshes too: they get the settings of the active one": "weitere Netze auswählen: sie erhalten die "
    "Einstellungen des aktiven",
    "Copy Settings to {count} Others": "Einstellungen auf {count} andere übertragen",
    "{count} more are waiting": "{count} weitere warten",
    "Cancel All": "Alle abbrechen",
    "settings of {name} given to {names}": "Einstellungen von {name} an {names} gegeben",
    "Vertices without a place: {count}": "Punkte ohne Ort: {count}",
    "Faces without area: {count}": "Flächen ohne Inhalt: {count}",
    "Doubled faces: {count}": "Doppelte Flächen: {count}",
    "Edges with three faces or more: {count}": "Kanten mit drei oder mehr Flächen: {count}",
    "Pinched vertices: {count}": "Punkte, an denen sich Flächen nur berühren: {count}",
    "Faces wound the other way: {count}": "Andersherum gewickelte Flächen: {count}",
    "One-sided, cut along edges: {count}": "Einseitig, aufgeschnitten an Kanten: {count}",
    "Next Defect": "Nächster Defekt",
    "Preview": "Vorschau",
    "Rendered": "Gerendert",
    "in the .blend": "in der .blend-Datei",
    "chosen objects": "gewählte Objekte",
    "First, Last": "Erstes, letztes",
    "Quad Pattern": "Vierecksmuster",
    "Remesh to Quads": "Zu Vierecken umnetzen",
    "Direction Field": "Richtungsfeld",
    "Another Variation": "Andere Variante",
    "Bake to Images": "In Bilder backen",
    "Direction Field (.rawfield, .rosy)": "Richtungsfeld (.rawfield, .rosy)",
    "No active object: select a mesh object": "Kein aktives Objekt: Wählen Sie ein Netzobjekt aus",
    "{meaning}.\nClick to copy the full report as JSON": "{meaning}.\nKlicken kopiert den ganzen Bericht als JSON",
    "What is left of the wish for even stripes along the directions: 0 is a perfect pattern": (
        "Was vom Wunsch nach gleichmäßigen Streifen entlang der Richtungen unerfüllt ist: 0 ist ein perfektes Muster"
    ),
    "No field at all on this mesh has less energy than this one by more than this share: its bound is proved by "
    "a factorization in double precision": (
        "Überhaupt kein Feld auf diesem Netz hat um mehr als diesen Anteil weniger Energie: Die Schranke ist durch "
        "eine Zerlegung in doppelter Genauigkeit bewiesen"
    ),
    "How much of the energy lies above the lower bound; the bound is estimated, not proved": (
        "Wie viel der Energie über der unteren Schranke liegt; sie ist geschätzt, nicht bewiesen"
    ),
    "Points around which the directions turn (disclinations): by a half for lines, by a quarter for crosses": (
        "Stellen, um die sich die Richtungen drehen (Disklinationen): bei Linien um ein halbes, bei Kreuzen um ein "
        "viertel Mal"
    ),
    "Points where a stripe begins or ends (dislocations)": (
        "Stellen, an denen ein Streifen beginnt oder endet (Versetzungen)"
    ),
    "How many times as far apart as asked lines are, on all but a hundredth of the surface at either end, and on how "
    "much of it they are off by more than a quarter; Spacing Error in the overlay shows where": (
        "Wievielmal so weit wie verlangt Linien auseinander liegen, bis auf je ein Hundertstel der Oberfläche an "
        "beiden Enden, und auf welchem Teil sie um mehr als ein Viertel daneben liegen; die Einblendung zeigt als "
        "Abstandsfehler, wo"
    ),
    "How long the last solve took, and on how many vertices": (
        "Wie lange die letzte Lösung auf wie vielen Punkten brauchte"
    ),
    "A loop of {count} quads": "Eine Schleife von {count} Vierecken",
    "A spiral of {count} quads": "Eine Spirale von {count} Vierecken",
    "Click near an edge: show its loop   Enter: done   Esc: as before": (
        "Nahe einer Kante klicken: ihre Schleife zeigen   Eingabe: fertig   Esc: wie vorher"
    ),
    "Click: place a defect   Drag: move it   Enter: done   Esc: as before": (
        "Klicken: Defekt setzen   Ziehen: bewegen   Eingabe: fertig   Esc: wie vorher"
    ),
}

REASONS = {
    "leave edit mode: loops are shown in object mode": (
        "den Bearbeitungsmodus verlassen: Schleifen zeigt der Objektmodus"
    ),
    "leave the present mode: fields are solved in object or edit mode": (
        "verlassen Sie den jetzigen Modus: Felder werden im Objekt- oder Bearbeitungsmodus gelöst"
    ),
    "leave the present mode: samples are added in object mode": (
        "verlassen Sie den jetzigen Modus: Beispiele werden im Objektmodus hinzugefügt"
    ),
    "{name} is being solved: wait for it, or cancel it": "{name} wird gerade gelöst: warten oder abbrechen",
    "something is being read or baked: wait for it, or cancel it with Esc": (
        "etwas wird gerade gelesen oder gebacken: warten oder mit Esc abbrechen"
    ),
    "the result waits for the end of the render": "das Ergebnis wartet auf das Ende des Renderns",
    "the result waits for object mode": "das Ergebnis wartet auf den Objektmodus",
    "the result waits for object mode of {name}": "das Ergebnis wartet auf den Objektmodus von {name}",
    "{name} has no pattern: solve stripes or quads on it first": (
        "{name} hat kein Muster: lösen Sie zuerst Streifen oder Vierecke darauf"
    ),
    "{name} shows no pattern: solve stripes or quads on it first": (
        "{name} zeigt kein Muster: lösen Sie zuerst Streifen oder Vierecke darauf"
    ),
    "{name} has no favourites: keep a variation first": "{name} hat keine Favoriten: behalten Sie zuerst eine Variante",
    "{name} has shape keys, which subdivision would lose: apply them first": (
        "{name} hat Formschlüssel, die beim Unterteilen verloren gingen: wenden Sie sie zuerst an"
    ),
    "{name} has no defects: its field is continuous, or not solved yet": (
        "{name} hat keine Defekte: das Feld ist stetig oder noch nicht gelöst"
    ),
    "{name} has no solve in memory (kept for the last {count} objects): solve it first": (
        "{name} hat keine Lösung im Speicher (behalten für die letzten {count} Objekte): lösen Sie es zuerst"
    ),
    "only the semidefinite method finds variations: choose it and solve again": (
        "nur das semidefinite Verfahren findet Varianten: wählen Sie es und lösen Sie neu"
    ),
    "defects are placed in stripes and quads: solve one of them first": (
        "Defekte werden in Streifen und Vierecke gesetzt: lösen Sie zuerst eines davon"
    ),
    "the report is kept while the file stays open: solve again to have one": (
        "der Bericht bleibt, solange die Datei offen ist: lösen Sie neu, um einen zu haben"
    ),
}
