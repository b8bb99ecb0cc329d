# SPDX-License-Identifier: GPL-3.0-or-later
"""What guides, constraints, the overlay, bakes and vortices say, in German."""

GUIDES = {
    "Add Guide": "Führung hinzufügen",
    "Add a guide to the blend": "Der Mischung eine Führung hinzufügen",
    "Remove Guide": "Führung entfernen",
    "Remove this guide from the blend": "Diese Führung aus der Mischung entfernen",
    "Largest Curvature": "Größte Krümmung",
    "Across ridges: where the surface bends most": "Quer zu Graten: wo sich die Oberfläche am stärksten biegt",
    "Smallest Curvature": "Kleinste Krümmung",
    "Along ridges: where the surface bends least": "An Graten entlang: wo sich die Oberfläche am wenigsten biegt",
    "Gradient": "Gefälle",
    "Where a float attribute or vertex group grows": "Wohin ein Gleitkommaattribut oder eine Punktgruppe wächst",
    "Contour": "Höhenlinie",
    "Along the lines on which a float attribute or vertex group is constant": (
        "An den Linien entlang, auf denen ein Gleitkommaattribut oder eine Punktgruppe gleich bleibt"
    ),
    "Away From": "Fort von",
    "Away from a vertex group, a curve or the boundary, on the shortest way": (
        "Auf kürzestem Weg fort von einer Punktgruppe, einer Kurve oder dem Rand"
    ),
    "Around": "Um herum",
    "Along the lines of equal distance from a vertex group, a curve or the boundary": (
        "An den Linien gleicher Entfernung von einer Punktgruppe, einer Kurve oder dem Rand entlang"
    ),
    "Axis": "Achse",
    "An axis of the object, projected to the surface": "Eine Achse des Objekts, auf die Oberfläche projiziert",
    "Axis of the object": "Achse des Objekts",
    "The object's X axis": "Die X-Achse des Objekts",
    "The object's Y axis": "Die Y-Achse des Objekts",
    "The object's Z axis": "Die Z-Achse des Objekts",
    "UV U": "UV-U",
    "Where the first coordinate of a UV map grows": "Wohin die erste Koordinate einer UV-Map wächst",
    "UV V": "UV-V",
    "Where the second coordinate of a UV map grows": "Wohin die zweite Koordinate einer UV-Map wächst",
    "Attribute": "Attribut",
    "A vector attribute on the vertices, projected to the surface": (
        "Ein Vektorattribut auf den Punkten, auf die Oberfläche projiziert"
    ),
    "File": "Datei",
    "A field file of another program: .rawfield or .rosy": (
        "Eine Felddatei eines anderen Programms: .rawfield oder .rosy"
    ),
    "A .rawfield or .rosy file of this mesh": "Eine .rawfield- oder .rosy-Datei dieses Netzes",
    "Values": "Werte",
    "Float attribute or vertex group on the vertices": "Gleitkommaattribut oder Punktgruppe auf den Punkten",
    "From": "Von",
    "Vertex group, curve object, or the word boundary": "Punktgruppe, Kurvenobjekt oder das Wort boundary",
    "UV Map": "UV-Map",
    "Empty for the active UV map": "Leer für die aktive UV-Map",
    "Vector attribute on the vertices": "Vektorattribut auf den Punkten",
    "Strength": "Stärke",
    "How strongly the directions follow, against smoothness and other guides": (
        "Wie stark die Richtungen folgen, gegenüber Glätte und anderen Führungen"
    ),
}

CONSTRAINTS = {
    "Add Constraint": "Bedingung hinzufügen",
    "Add a row to the list of constraints": "Der Liste der Bedingungen eine Zeile hinzufügen",
    "Remove Constraint": "Bedingung entfernen",
    "Remove the active row": "Die aktive Zeile entfernen",
    "Move Constraint": "Bedingung verschieben",
    "Move the active row up or down": "Die aktive Zeile nach oben oder unten verschieben",
    "Direction": "Richtung",
    "Where the row goes": "Wohin die Zeile geht",
    "Up": "Nach oben",
    "Down": "Nach unten",
    "Where": "Wo",
    "Where something is asked for": "Wo etwas verlangt wird",
    "The open edges of the mesh, or those of a vertex group": "Die offenen Kanten des Netzes oder einer Punktgruppe",
    "The chains of edges, areas and points of a vertex group": (
        "Die Kantenzüge, Flächen und einzelnen Punkte einer Punktgruppe"
    ),
    "Seams": "Nähte",
    "Edges marked as seams": "Als Naht markierte Kanten",
    "Sharp Edges": "Scharfe Kanten",
    "Edges marked as sharp": "Als scharf markierte Kanten",
    "Creases": "Falze",
    "Edges with a crease": "Kanten mit einem Falz",
    "Curve": "Kurve",
    "A curve or drawn strokes of another object, projected to the surface": (
        "Eine Kurve oder gezeichnete Striche eines anderen Objekts, auf die Oberfläche projiziert"
    ),
    "A curve, a Grease Pencil object, or a mesh of edges": (
        "Eine Kurve, ein Grease-Pencil-Objekt oder ein Netz aus Kanten"
    ),
    "Vertices, each with a direction or a phase of its own": "Punkte, jeder mit eigener Richtung oder Phase",
    "Vector attribute on the vertices; for phases a float attribute, in radians, or a vertex group": (
        "Vektorattribut auf den Punkten; für Phasen ein Gleitkommaattribut im Bogenmaß oder eine Punktgruppe"
    ),
    "Ask For": "Verlangt",
    "What is asked for there": "Was dort verlangt wird",
    "Stripes run along the line, or along the attribute's vectors": (
        "Streifen laufen an der Linie oder den Vektoren des Attributs entlang"
    ),
    "Stripes meet the line at a right angle": "Streifen treffen im rechten Winkel auf die Linie",
    "Stripes meet the line at an angle": "Streifen treffen in einem Winkel auf die Linie",
    "From the line, counterclockwise seen from outside": "Von der Linie aus, von außen gegen den Uhrzeigersinn",
    "Phase": "Phase",
    "A stripe lies on the line: its middle at 0°, the middle of a gap at 180°": (
        "Ein Streifen liegt auf der Linie: seine Mitte bei 0°, die Mitte einer Lücke bei 180°"
    ),
    "0° is the middle of a stripe, 180° the middle of a gap; it grows to the left of the line": (
        "0° ist die Mitte eines Streifens, 180° die einer Lücke; sie wächst links der Linie"
    ),
    "Same Phase": "Gleiche Phase",
    "The line follows one stripe, at a distance from its middle that is left free": (
        "Die Linie folgt einem Streifen, in freiem Abstand von seiner Mitte"
    ),
    "Cut": "Schnitt",
    "Nothing is carried across: the panels on both sides have patterns of their own": (
        "Nichts wird hinübergetragen: Die Teile auf beiden Seiten haben eigene Muster"
    ),
    "Vertices with a weight above zero": "Punkte mit einem Gewicht über null",
    "Soft": "Weich",
    "Draw the pattern towards this, instead of holding it exactly": (
        "Das Muster hierhin ziehen, statt es genau einzuhalten"
    ),
    "Weight": "Gewicht",
    "How strongly it draws: at 1 about as strongly as the rest of the surface holds against it": (
        "Wie stark es zieht: bei 1 etwa so stark, wie die übrige Oberfläche dagegenhält"
    ),
    "Enabled": "Aktiv",
    "Use this row": "Diese Zeile verwenden",
}

OVERLAY = {
    "Draw the field of the active object over it": "Das Feld des aktiven Objekts darüberzeichnen",
    "Solid": "Solide",
    "Draw patterns in Solid view too, which shows no materials by itself": "Muster auch in der soliden Ansicht "
    "zeichnen, die von sich aus keine Materialien zeigt",
    "How directions are drawn": "Wie Richtungen gezeichnet werden",
    "None": "Keine",
    "Do not draw directions": "Keine Richtungen zeichnen",
    "Marks": "Marken",
    "A line, cross or arrow at the vertices": "Eine Linie, ein Kreuz oder ein Pfeil an den Punkten",
    "Streamlines": "Feldlinien",
    "Lines that follow the directions": "Linien, die den Richtungen folgen",
    "Defects": "Defekte",
    "Disclinations and dislocations, in the colours of their empties": (
        "Disklinationen und Versetzungen, in den Farben ihrer Leerobjekte"
    ),
    "Edges of the constraint list, coloured by what they ask for, and pinned faces": (
        "Kanten der Liste von Bedingungen, gefärbt nach dem, was verlangt ist, und festgesetzte Flächen"
    ),
    "Spacing Error": "Abstandsfehler",
    "Faces in colours: red where lines are further apart than asked, blue where they are nearer, white where they are "
    "as asked; full from one and a half times on": (
        "Flächen in Farben: rot, wo Linien weiter auseinander liegen als verlangt, blau, wo sie enger liegen, weiß, wo "
        "sie stimmen; voll ab dem Anderthalbfachen"
    ),
    "Loop": "Schleife",
    "The loop of quads that was last clicked on, spirals in another colour": (
        "Die zuletzt angeklickte Schleife von Vierecken, Spiralen in einer anderen Farbe"
    ),
}

BAKE = {
    "Maps": "Karten",
    "Images to bake; click with Shift to choose several": "Zu backende Bilder; mit Umschalt mehrere wählen",
    "Mask": "Maske",
    "1 in a stripe or on a line, 0 elsewhere, on all faces": (
        "1 in Streifen oder auf Linien, sonst 0, auf allen Flächen"
    ),
    "Color": "Farbe",
    "The base color of what is rendered": "Die Grundfarbe dessen, was gerendert wird",
    "Height": "Höhe",
    "Height of the pattern from 0 to 1, with 16 bits": "Höhe des Musters von 0 bis 1, mit 16 Bit",
    "Normal": "Normale",
    "Tangent space normals of what is rendered, with its bump": "Tangentennormalen des Gerenderten, mit seinem Relief",
    "Cosine and size of the sine of the phase; of quads, both cosines in order": (
        "Kosinus und Betrag des Sinus der Phase; bei Vierecken beide Kosinus der Reihe nach"
    ),
    "Index": "Index",
    "A number for each stripe or quad; a stripe ends at defects": (
        "Eine Nummer für jeden Streifen oder jedes Viereck; ein Streifen endet an Defekten"
    ),
    "Size": "Größe",
    "Width and height of the images in pixels": "Breite und Höhe der Bilder in Pixeln",
    "Margin": "Überstand",
    "How far the image goes on beyond the edges of UV islands, so that no background shows at seams": (
        "Wie weit das Bild über UV-Inseln hinausgeht, damit an Nähten kein Hintergrund erscheint"
    ),
    "Samples": "Abtastungen",
    "For each pixel: more make edges smoother and take longer": (
        "Je Pixel: mehr machen Ränder glatter und dauern länger"
    ),
    "Where on the image each face is; empty for the active map": (
        "Wo im Bild jede Fläche liegt; leer für die aktive Map"
    ),
    "Smart UV Project": "Smart UV Project",
    "Make the UV map if the mesh does not have it; where none is named, 'Synch Bake'": (
        "Die UV-Map anlegen, wenn das Netz sie nicht hat; ohne Namen „Synch Bake“"
    ),
    "Folder": "Ordner",
    "Where the files go; empty to pack the images into the .blend": (
        "Wohin die Dateien kommen; leer, um die Bilder in die .blend-Datei zu packen"
    ),
    "Name": "Name",
    "Of each file or image; {object} and {map} are filled in": "Jeder Datei; {object} und {map} werden eingesetzt",
    "Format": "Format",
    "Kind of the images": "Art der Bilder",
    "PNG": "PNG",
    "8 bits, and 16 for height, phase and index": "8 Bit, und 16 für Höhe, Phase und Index",
    "OpenEXR": "OpenEXR",
    "Floating-point numbers: 16 bits, and 32 for height, phase and index": (
        "Gleitkommazahlen: 16 Bit, und 32 für Höhe, Phase und Index"
    ),
    "Material of Images": "Material aus Bildern",
    "Show the images in place of the pattern; its material is kept, and is what the next bake shows": (
        "Die Bilder statt des Musters zeigen; sein Material bleibt und ist, was die nächste Backung zeigt"
    ),
    "Displacement": "Verschiebung",
    "Let the new material displace the surface by the height when it is rendered": (
        "Das neue Material die Oberfläche beim Rendern um die Höhe verschieben lassen"
    ),
}

VORTICES = {
    "Vortex filaments and tubes of a flow in space": "Wirbelfäden und -röhren einer Strömung im Raum",
    "What the last solve of the active object's vortices found": (
        "Was die letzte Lösung der Wirbel des aktiven Objekts ergeben hat"
    ),
    "Core": "Kern",
    "Radius over which the vorticity of curves is spread, in cells; 0 for half a cell, and two where tubes are shown": (
        "Radius in Zellen, über den die Wirbelstärke von Kurven verteilt ist; 0 für eine halbe, und zwei, wo Röhren "
        "gezeigt werden"
    ),
    "How often points of filaments and tubes move to the middle of their neighbours": (
        "Wie oft Punkte von Fäden und Röhren in die Mitte ihrer Nachbarn rücken"
    ),
    "Point": "Punkt",
    "Point of the sphere: filaments are where the map shows its antipode, tubes around that": (
        "Punkt der Kugel: Fäden liegen, wo die Abbildung seinen Antipoden zeigt, Röhren darum herum"
    ),
    "What the panel shows of the solve, as JSON": "Was das Panel von der Lösung zeigt, als JSON",
    "Sources": "Quellen",
    "Names of the objects that the flow was read from, as JSON": (
        "Namen der Objekte, aus denen die Strömung gelesen wurde, als JSON"
    ),
    "Proved: no map saves more than {gap:.0%}": "Bewiesen: keine Abbildung spart mehr als {gap:.0%}",
    "{closed} closed, {length:.3g} long in all": "{closed} geschlossen, zusammen {length:.3g} lang",
    "Circulation {quantum:.4g} each: {share:.0%} of the vorticity": (
        "Zirkulation je {quantum:.4g}: {share:.0%} der Wirbelstärke"
    ),
    "{seconds:.1f} s, {nodes} nodes": "{seconds:.1f} s, {nodes} Knoten",
    "{sizes} nodes, about {gigabytes:.1f} GB": "{sizes} Knoten, etwa {gigabytes:.1f} GB",
    "filament": "Faden",
    "filaments": "Fäden",
    "tube": "Röhre",
    "tubes": "Röhren",
    "vortex": "Wirbel",
    "vortices": "Wirbel",
    "Show the vortices of a file, of the active volume or mesh, or of the flow that the selected curves induce": (
        "Die Wirbel einer Datei, des aktiven Volumens oder Netzes oder der Strömung ausgewählter Kurven zeigen"
    ),
    "Least Energy": "Kleinste Energie",
    "Export Filaments": "Filamente exportieren",
    "Write the filaments to a file for other programs: a table (.csv) or polylines (.vtp, .vtk)": (
        "Die Filamente für andere Programme schreiben: Tabelle (.csv) oder Linienzüge (.vtp, .vtk)"
    ),
    "Unwrapped": "Ausgerollt",
    "Draw filaments in one piece where they leave a periodic box, instead of in parts that lie in it": (
        "Filamente, die einen periodischen Kasten verlassen, in einem Stück zeichnen statt in Teilen in ihm"
    ),
    "Show the filaments of least energy again, and the tubes seen from the north": (
        "Die Fäden kleinster Energie wieder zeigen, und die Röhren von Norden gesehen"
    ),
    "OpenVDB or NumPy file with a velocity, #### for frame numbers; empty for the chosen objects": (
        "OpenVDB- oder NumPy-Datei mit einer Geschwindigkeit, #### für Bildnummern; leer für die gewählten Objekte"
    ),
    "Show": "Zeigen",
    "How vortices are shown": "Wie Wirbel gezeigt werden",
    "Filaments": "Fäden",
    "Curves that carry the same circulation each": "Kurven, die alle dieselbe Zirkulation tragen",
    "Tubes": "Röhren",
    "Surfaces around the vorticity, coloured by the map; by the method Semidefinite": (
        "Flächen um die Wirbelstärke, gefärbt nach der Abbildung; mit dem Verfahren Semidefinit"
    ),
    "Both": "Beide",
    "Filaments and tubes, of one solve": "Fäden und Röhren aus einer Lösung",
    "Resolution": "Auflösung",
    "Nodes of the grid along its longest side; a NumPy file has a grid of its own": (
        "Knoten des Gitters an seiner längsten Seite; eine NumPy-Datei hat ein eigenes Gitter"
    ),
    "Circulation": "Zirkulation",
    "How the circulation of one filament is chosen": "Wie die Zirkulation eines Fadens gewählt wird",
    "So many pass the plane with most vorticity": "So viele gehen durch die Ebene mit der größten Wirbelstärke",
    "So many through the plane with most vorticity": "So viele durch die Ebene mit der größten Wirbelstärke",
    "Quantum": "Quant",
    "It is given": "Sie ist gegeben",
    "Of one filament, in the units of the velocity times length": (
        "Eines Fadens, in Einheiten von Geschwindigkeit mal Länge"
    ),
    "Width": "Breite",
    "How much of the sphere is inside a tube, degrees around the chosen point's antipode": (
        "Wie viel der Kugel in einer Röhre liegt, Grad um den Gegenpunkt des gewählten Punkts"
    ),
    "Frames": "Bilder",
    "Solve a range of frames, each from the one before: one object a frame": (
        "Eine Folge von Bildern lösen, jedes vom vorigen aus: ein Objekt je Bild"
    ),
    "First Frame": "Erstes Bild",
    "Last Frame": "Letztes Bild",
    "Of the range": "Der Folge",
    "Velocity on the vertices of the chosen mesh, which then shows the map itself, or grid of a volume": (
        "Geschwindigkeit auf den Punkten des gewählten Netzes, das dann selbst die Abbildung zeigt, "
        "oder das Gitter eines Volumens"
    ),
}

ANIMATION = {
    "Animation": "Animation",
    "The pattern in each frame of a moving mesh": "Das Muster in jedem Bild eines bewegten Netzes",
    "Animate": "Animieren",
    "Animate the Pattern": "Muster animieren",
    "Solve the pattern in each frame of a moving or deforming mesh, each frame from the one before": (
        "Das Muster in jedem Bild eines bewegten oder verformten Netzes lösen, jedes aus dem vorigen"
    ),
    "Pattern": "Muster",
    "What is solved in each frame": "Was in jedem Bild gelöst wird",
    "Evenly spaced stripes along a vector or line field": (
        "Gleichmäßige Streifen entlang eines Vektor- oder Linienfelds"
    ),
    "Two crossing families of lines along a cross field": "Zwei sich kreuzende Scharen entlang eines Kreuzfelds",
    "Scene Range": "Bereich der Szene",
    "Solve all frames of the scene": "Alle Bilder der Szene lösen",
    "First Frame": "Erstes Bild",
    "First frame to solve": "Das erste Bild, das gelöst wird",
    "Last Frame": "Letztes Bild",
    "Last frame to solve": "Das letzte Bild, das gelöst wird",
    "Hold": "Halt",
    "How strongly the pattern holds on to the frame before: at 0 it may jump where the mesh moves on, "
    "larger values let it slide more slowly": (
        "Wie fest sich das Muster an das vorige Bild hält: Bei 0 kann es springen, größere Werte lassen es gleiten"
    ),
    "Animated: a new solve replaces it": "Animiert: Eine neue Lösung ersetzt es",
}
