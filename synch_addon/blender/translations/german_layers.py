# SPDX-License-Identifier: GPL-3.0-or-later
"""German: layers in solids."""

LAYERS = {
    "Layers": "Schichten",
    "Layers in the Solid": "Schichten im Körper",
    "Evenly spaced layers in the solid that a closed mesh encloses": (
        "Gleichmäßige Schichten im Körper, den ein geschlossenes Netz umschließt"
    ),
    "Fill the closed mesh with evenly spaced layers that follow a direction and end flush with chosen surfaces": (
        "Das geschlossene Netz mit gleichmäßigen Schichten füllen, die einer Richtung folgen und bündig mit gewählten "
        "Flächen enden"
    ),
    "Layers of {name}": "Schichten von {name}",
    "About {tets:,} tetrahedra, {megabytes:,.0f} MB": "Etwa {tets:,} Tetraeder, {megabytes:,.0f} MB",
    "Add Group": "Gruppe hinzufügen",
    "Ask something of the layers on a part of the surface": "Auf einem Teil der Fläche etwas verlangen",
    "Remove Group": "Gruppe entfernen",
    "Ask nothing of the layers there": "Dort nichts von den Schichten verlangen",
    "Row": "Zeile",
    "Which of the rows, from 0 on": "Welche der Zeilen, von 0 an",
    "What the layers follow": "Woran sich die Schichten ausrichten",
    "What the layers follow, such as axis:Z or harmonic:Bottom:Top": (
        "Woran sich die Schichten ausrichten, etwa axis:Z oder harmonic:Unten:Oben"
    ),
    "What is asked of parts of the surface, such as Top=layer,Bottom=constant": (
        "Was auf Teilen der Fläche verlangt ist, etwa Oben=layer,Unten=constant"
    ),
    "An axis of the object: flat layers": "Eine Achse des Objekts: ebene Schichten",
    "Between Groups": "Zwischen Gruppen",
    "From one vertex group's faces to another's, along a harmonic function": (
        "Von den Flächen einer Vertexgruppe zu denen einer anderen, entlang einer harmonischen Funktion"
    ),
    "Away from a vertex group's faces, from the whole surface, or from another mesh": (
        "Weg von den Flächen einer Vertexgruppe, von der ganzen Fläche oder von einem anderen Netz"
    ),
    "Along Curve": "Entlang einer Kurve",
    "Along a curve object: layers cross it": "Entlang eines Kurvenobjekts: Schichten queren es",
    "Around Curve": "Um eine Kurve",
    "Away from a curve object: layers lie around it like skins": (
        "Weg von einem Kurvenobjekt: Schichten liegen wie Häute darum"
    ),
    "A vector attribute on the vertices, extended into the solid": (
        "Ein Vektorattribut auf den Punkten, in den Körper fortgesetzt"
    ),
    "Vectors in a solid, on points or cells of a .vtu or .sol file": (
        "Vektoren in einem Körper, an Punkten oder Zellen einer .vtu- oder .sol-Datei"
    ),
    "File of Lines": "Datei mit Linien",
    "The same for vectors of either sign, such as principal stresses": (
        "Das Gleiche für Vektoren ohne Vorzeichen, etwa Hauptspannungen"
    ),
    "A .vtu, or a .sol beside its .mesh, with vectors in the solid": (
        "Eine .vtu, oder eine .sol neben ihrer .mesh, mit Vektoren im Körper"
    ),
    "Array": "Feld",
    "Name of the array of vectors; empty for the only one": "Name des Vektorfelds; leer für das einzige",
    "Axis of the object": "Achse des Objekts",
    "Vertex group where the layers begin": "Vertexgruppe, an der die Schichten beginnen",
    "To": "Bis",
    "Vertex group where the layers end": "Vertexgruppe, an der die Schichten enden",
    "Vertex group, mesh object, or the word boundary": "Vertexgruppe, Netzobjekt oder das Wort boundary",
    "Curve or Grease Pencil object": "Kurven- oder Grease-Pencil-Objekt",
    "Groups": "Gruppen",
    "What is asked of parts of the surface": "Was auf Teilen der Fläche verlangt ist",
    "What is asked of the layers on a part of the surface": "Was auf einem Teil der Fläche verlangt ist",
    "Group": "Gruppe",
    "Vertex group, or the word boundary": "Vertexgruppe oder das Wort boundary",
    "Wish": "Wunsch",
    "What the layers do there": "Was die Schichten dort tun",
    "Layer on It": "Schicht darauf",
    "A layer lies exactly on these faces": "Eine Schicht liegt genau auf diesen Flächen",
    "Parallel": "Parallel",
    "Layers run along each piece of these faces, at whichever distance": (
        "Schichten laufen an jedem Stück dieser Flächen entlang, in irgendeinem Abstand"
    ),
    "Distance from one layer to the next; the object's scale counts": (
        "Abstand von einer Schicht zur nächsten; die Skalierung des Objekts zählt"
    ),
    "As many layers as the resolution carries, forty at most": "So viele, wie die Auflösung trägt, höchstens vierzig",
    "Resolution": "Auflösung",
    "Longest edge of the tetrahedra that fill the object, at most half the spacing": (
        "Längste Kante der Tetraeder, die das Objekt füllen, höchstens der halbe Abstand"
    ),
    "Automatic Resolution": "Automatische Auflösung",
    "Numbers": "Nummern",
    "What counts as one layer: in the attribute, in files and where paths are ordered": (
        "Was als eine Schicht zählt: im Attribut, in Dateien und in der Reihenfolge der Wege"
    ),
    "Of Pieces": "Der Stücke",
    "Each connected piece has a number of its own, from the bottom": (
        "Jedes zusammenhängende Stück hat eine eigene Nummer, von unten an"
    ),
    "Of Levels": "Der Ebenen",
    "Pieces at one height have one number, each body's from its lowest layer on": (
        "Stücke auf einer Höhe haben eine Nummer, die jedes Körpers von seiner untersten Schicht an"
    ),
    "Smallest Height": "Kleinste Höhe",
    "Of a layer: with limits they branch as little as keeps to these; 0 for none": (
        "Einer Schicht: mit Grenzen verzweigen sie sich nur so wenig, dass sie diese einhalten; 0 für keine"
    ),
    "Largest Height": "Größte Höhe",
    "Of a layer, above the smallest one; 0 for none": "Einer Schicht, über der kleinsten; 0 für keine",
    "About a hundred thousand tetrahedra, or more where the spacing needs them": (
        "Etwa hunderttausend Tetraeder, oder mehr, wo der Abstand sie braucht"
    ),
    "Print and Show": "Drucken und Zeigen",
    "Files, tool paths and a volume of the layers that were solved last": (
        "Dateien, Werkzeugwege und ein Volumen der zuletzt gelösten Schichten"
    ),
    "Export Layers": "Schichten exportieren",
    "Write the layers to mesh files, numbered from bottom to top (.stl, .ply or .obj)": (
        "Die Schichten in Meshdateien schreiben, von unten nach oben nummeriert (.stl, .ply oder .obj)"
    ),
    "One File": "Eine Datei",
    "All layers in one file, instead of one file for each": "Alle Schichten in einer Datei statt jede in ihrer eigenen",
    "Tool Paths": "Werkzeugwege",
    "Make curves for a tool to follow on each layer, one object for each in a collection of their own": (
        "Auf jeder Schicht Kurven machen, denen ein Werkzeug folgt, je ein Objekt in einer eigenen Sammlung"
    ),
    "Export Tool Paths": "Werkzeugwege exportieren",
    "Make the curves of the tool paths, and write a table (.csv), polylines (.obj) or a printer's program (.gcode)": (
        "Die Kurven der Werkzeugwege machen und eine Tabelle (.csv), Linienzüge (.obj) oder ein Druckprogramm (.gcode) "
        "schreiben"
    ),
    "Machine": "Maschine",
    "File that says what the printer is (.toml); none for three axes, a scene unit a millimetre": (
        "Datei, die den Drucker beschreibt (.toml); ohne sie drei Achsen, eine Einheit der Szene ein Millimeter"
    ),
    "Offset": "Versatz",
    "How far the faces lie above the last layer, in layers: a half for beads that end at them": (
        "Wie weit die Flächen über der letzten Schicht liegen, in Schichten: ein Halb für Raupen, die an ihnen enden"
    ),
    "Fill": "Füllung",
    "How paths fill a layer": "Wie Wege eine Schicht füllen",
    "One inside the other, from the rim of each layer inwards": "Einer im anderen, vom Rand jeder Schicht nach innen",
    "Across X": "Quer zu X",
    "In planes across the object's X axis": "In Ebenen quer zur X-Achse des Objekts",
    "Across Y": "Quer zu Y",
    "In planes across the object's Y axis": "In Ebenen quer zur Y-Achse des Objekts",
    "Across Z": "Quer zu Z",
    "In planes across the object's Z axis": "In Ebenen quer zur Z-Achse des Objekts",
    "Step": "Schritt",
    "Between two paths; 0 for the spacing of the layers": "Zwischen zwei Wegen; 0 für den Abstand der Schichten",
    "Volume of the Layers": "Volumen der Schichten",
    "Write the pattern to an OpenVDB file, and make a volume object that shows the layers as sheets of smoke": (
        "Das Muster in eine OpenVDB-Datei schreiben und ein Volumenobjekt machen, das die Schichten wie Rauch zeigt"
    ),
    "Voxels along the longest side": "Voxel entlang der längsten Seite",
}
