# SPDX-License-Identifier: GPL-3.0-or-later
"""What errors and warnings are put together from, in German: parts of sentences, and words that stand for settings."""

PARTS = {
    "{elements} has {what}: {done}": "{elements} hat {what}: {done}",
    "{elements} have {what}: {done}": "{elements} haben {what}: {done}",
    "{elements} has {what}: use {menu}": "{elements} hat {what}: {menu} verwenden",
    "{elements} have {what}: use {menu}": "{elements} haben {what}: {menu} verwenden",
    "vertex {index}": "Punkt {index}",
    "vertices {indices}": "Punkte {indices}",
    "vertices {indices} and {more} more": "Punkte {indices} und {more} weitere",
    "face {index}": "Fläche {index}",
    "faces {indices}": "Flächen {indices}",
    "faces {indices} and {more} more": "Flächen {indices} und {more} weitere",
    "edge {index}": "Kante {index}",
    "edges {indices}": "Kanten {indices}",
    "edges {indices} and {more} more": "Kanten {indices} und {more} weitere",
    "triangle {index}": "Dreieck {index}",
    "triangles {indices}": "Dreiecke {indices}",
    "triangles {indices} and {more} more": "Dreiecke {indices} und {more} weitere",
    "tetrahedron {index}": "Tetraeder {index}",
    "tetrahedra {indices}": "Tetraeder {indices}",
    "tetrahedra {indices} and {more} more": "Tetraeder {indices} und {more} weitere",
    "frame {index}": "Bild {index}",
    "frames {indices}": "Bilder {indices}",
    "frames {indices} and {more} more": "Bilder {indices} und {more} weitere",
    "faces {indices} at the edge between vertices {i} and {j}": (
        "Flächen {indices} an der Kante zwischen den Punkten {i} und {j}"
    ),
    "faces {indices} at the edge between vertices {i} and {j} (in the piece of vertex {first}, one of {pieces})": (
        "Flächen {indices} an der Kante zwischen den Punkten {i} und {j} (im Stück des Punkts {first}, einem von "
        "{pieces})"
    ),
    "the edge between vertices {i} and {j}": "die Kante zwischen den Punkten {i} und {j}",
    "the edge between vertices {i} and {j} and {more} more": (
        "die Kante zwischen den Punkten {i} und {j} und {more} weitere"
    ),
    "{what} (in the piece of vertex {first}, one of {pieces})": (
        "{what} (im Stück des Punkts {first}, einem von {pieces})"
    ),
    "the constraint {row}": "die Bedingung {row}",
    "the vertex group {name}": "die Punktgruppe {name}",
    "the boundary": "der Rand",
    "the mirror": "der Spiegel",
    "the mirror in {axis}": "der Spiegel in {axis}",
    "the guiding curve": "die führende Kurve",
    "a UV map, or nothing for the active one": "eine UV-Map, oder nichts für die aktive",
    "a vertex group, a curve object or boundary": "eine Punktgruppe, ein Kurvenobjekt oder boundary",
    "a float attribute or vertex group": "ein Gleitkommaattribut oder eine Punktgruppe",
    "a vector attribute": "ein Vektorattribut",
    "a .rawfield or .rosy file": "eine .rawfield- oder .rosy-Datei",
    "X, Y or Z": "X, Y oder Z",
    "a vertex group": "eine Punktgruppe",
    "a curve object": "ein Kurvenobjekt",
    "an attribute": "ein Attribut",
    "a positive factor on the spacing": "einen positiven Faktor auf den Abstand",
    "a finite angle in radians": "einen endlichen Winkel im Bogenmaß",
    "tangential vector": "einen tangentialen Vektor",
    "group of sources": "der Gruppe der Quellen",
    "low group": "der unteren Gruppe",
    "high group": "der oberen Gruppe",
    "guidance vector": "der Führungsvektor",
    "a whole number": "eine ganze Zahl",
    "a number": "eine Zahl",
    "a text": "einen Text",
    "True or False": "True oder False",
    "the container's memory": "Speicher des Containers",
    "address space": "Adressraum",
    "use a machine with more": "einen Rechner mit mehr verwenden",
    "allow it more": "ihm mehr erlauben",
    "raise its limit (ulimit -v)": "seine Grenze erhöhen (ulimit -v)",
    "a solve of {count} phases": "eine Lösung von {count} Phasen",
    "a solve of layers in {count} tetrahedra": "eine Lösung von Schichten in {count} Tetraedern",
    "the lines cross the mesh's edges": "die Linien kreuzen die Kanten des Netzes",
    "grid lines may cross one another": "Gitterlinien können einander kreuzen",
    "the solid falls apart into {count} pieces": "der Körper zerfällt in {count} Stücke",
    "the solid has {count} holes where the surface has none": (
        "der Körper hat {count} Löcher, wo die Oberfläche keine hat"
    ),
    "the solid lacks {count} holes that the surface has": "dem Körper fehlen {count} Löcher, die die Oberfläche hat",
    "the solid leaves out {share} of the surface": "der Körper lässt {share} der Oberfläche aus",
    "has {holes} that the surface has not, where it closes narrow gaps": (
        "hat {holes}, die der Oberfläche fehlen, wo er schmale Lücken schließt"
    ),
    "lacks {holes} of the surface, too narrow for it": "lässt {holes} der Oberfläche aus, die zu eng für ihn sind",
    "{count} hole": "{count} Loch",
    "{count} holes": "{count} Löcher",
    "no finite position": "keinen endlichen Ort",
    "no area": "keine Fläche",
    "no volume": "kein Volumen",
    "its corners in the wrong order": "Ecken in falscher Reihenfolge",
    "the same corners as another face": "dieselben Ecken wie eine andere Fläche",
    "three or more faces": "drei oder mehr Flächen",
    "faces that touch only at this point": "Flächen, die sich nur in diesem Punkt berühren",
    "the opposite winding of their neighbours": "den umgekehrten Umlauf ihrer Nachbarn",
    "both sides of a one-sided surface": "beide Seiten einer einseitigen Oberfläche",
    "their faces are left out": "ihre Flächen werden ausgelassen",
    "left out of the surface": "aus der Oberfläche ausgelassen",
    "they count once, and look like it": "sie zählen einmal und sehen so aus",
    "those that bend least stay joined, others come apart": (
        "die sich am wenigsten biegen, bleiben verbunden, andere lösen sich"
    ),
    "they come apart": "sie lösen sich voneinander",
    "they count as turned over": "sie zählen als umgedreht",
    "it is open there, with the same on both sides": "sie ist dort offen, mit demselben auf beiden Seiten",
    "delete it or set its coordinates": "ihn löschen oder seine Koordinaten setzen",
    "separate them with Mesh > Split > Faces & Edges by Vertices, or rip the vertex (V)": (
        "sie trennen mit Netz > Teilen > Flächen & Kanten nach Punkten, oder den Punkt aufreißen (V)"
    ),
    "Mesh > Clean Up > Degenerate Dissolve": "Netz > Aufräumen > Entartetes auflösen",
    "a curve without points": "eine Kurve ohne Punkte",
    "faces of {count} corners with the vertices of {given}": "Flächen aus {count} Ecken mit den Punkten von {given}",
    "a face at vertex {number} of {count}": "eine Fläche am Punkt {number} von {count}",
    "face {number} with {different} different vertices at {size} corners": (
        "Fläche {number} mit {different} verschiedenen Punkten an {size} Ecken"
    ),
    "point {number} of {count} at a place that is not finite": (
        "Punkt {number} von {count} an einem Ort, der nicht endlich ist"
    ),
    "Mesh > Clean Up > Merge by Distance": "Netz > Aufräumen > Nach Abstand verschmelzen",
    "collapse its shortest edge, or mesh the solid again": (
        "seine kürzeste Kante einklappen oder den Körper neu vernetzen"
    ),
    "swap two of them": "zwei davon vertauschen",
    "more than two": "mehr als zwei",
    "two on the same side": "zwei auf derselben Seite",
    "add both ends of at least one to {name}": "beide Enden mindestens einer Kante zu {name} hinzufügen",
    "mark edges with Mark Seam first": "zuerst Kanten als Naht markieren",
    "mark edges with Mark Sharp first": "zuerst Kanten als scharf markieren",
    "mark edges with Edge Crease first": "zuerst Kanten eine Falte geben",
    "set the symmetry to {symmetry}": "die Symmetrie auf {symmetry} setzen",
    "set the symmetry to {symmetry} or {other}": "die Symmetrie auf {symmetry} oder {other} setzen",
    "leave it out": "sie weglassen",
    "or show filaments, whose tubes have one thickness": "oder Fäden zeigen, deren Röhren überall gleich dick sind",
    "on air": "in der Luft",
    "where the tool meets what is printed": "wo das Werkzeug auf Gedrucktes trifft",
    "lower than the nozzle's {height} mm": "niedriger als die {height} mm der Düse",
    "higher than the nozzle's {height} mm": "höher als die {height} mm der Düse",
    "steeper than {angle} degrees": "steiler als {angle} Grad",
    "give a smallest height, or a larger spacing": "eine kleinste Höhe oder einen größeren Abstand angeben",
    "give a largest height, or a smaller spacing": "eine größte Höhe oder einen kleineren Abstand angeben",
    "turn the object or the guidance": "das Objekt oder die Führung drehen",
    "turn the object, or support it": "das Objekt drehen oder stützen",
    "take a slimmer nozzle or flatter layers": "eine schlankere Düse oder flachere Schichten nehmen",
    "{count} piece": "{count} Stück",
    "{count} pieces": "{count} Stücke",
    "the pattern is": "das Muster ist",
    "layers are": "Schichten sind",
    "the pattern": "das Muster",
    "the phase": "die Phase",
    "UV map": "UV-Map",
    "UV map {name}": "UV-Map {name}",
    "none yet": "noch keine",
    " from {least} to {most}": " von {least} bis {most}",
    " at vertex {number} ({count} in all)": " an Punkt {number} (insgesamt {count})",
    "kept for the last {count} objects while the file is open": (
        "behalten für die letzten {count} Objekte, solange die Datei offen ist"
    ),
    "kept for the last {count} objects": "behalten für die letzten {count} Objekte",
    "{spacing} at vertex {number} ({count} in all)": "{spacing} an Punkt {number} (insgesamt {count})",
    "no layer lies in the solid, which is about {depth} deep for them: give a spacing below that": (
        "im Körper liegt keine Schicht, er ist für sie etwa {depth} tief: einen kleineren Abstand angeben"
    ),
    "no layer lies in the solid, whose phase is the same everywhere: change the guidance or the groups": (
        "im Körper liegt keine Schicht, die Phase ist überall gleich: die Führung oder die Gruppen ändern"
    ),
    "this takes more than {limit} MB of memory: use a coarser mesh, or raise the limit in Preferences > "
    "Add-ons > Synch Fields": (
        "das braucht mehr als {limit} MB Speicher: ein gröberes Netz verwenden, oder die Grenze unter "
        "Einstellungen > Add-ons > Synch Fields erhöhen"
    ),
    "the process that solves has ended ({how}): nothing was changed, run again": (
        "der Prozess, der löst, hat geendet ({how}): nichts wurde geändert, noch einmal ausführen"
    ),
    "the process that solves could not read what it was asked: nothing was changed": (
        "der Prozess, der löst, konnte nicht lesen, was er sollte: nichts wurde geändert"
    ),
    "cancelled: nothing was changed": "abgebrochen: nichts wurde geändert",
    "the object has no number: give one of bpy.data.objects": (
        "das Objekt hat keine Nummer: eines von bpy.data.objects angeben"
    ),
    "{name} is hidden and does not move: show it in the viewport": (
        "{name} ist ausgeblendet und bewegt sich nicht: in der Ansicht einblenden"
    ),
    "leave the present mode: vortices are made in object mode": (
        "verlassen Sie den jetzigen Modus: Wirbel entstehen im Objektmodus"
    ),
    "vortices are being solved: wait for them, or cancel them": "Wirbel werden gerade gelöst: warten oder abbrechen",
    "{name} is an attribute, and vertex groups are painted: empty the field for a new one": (
        "{name} ist ein Attribut, und gemalt werden Punktgruppen: das Feld für eine neue leeren"
    ),
    "strokes are drawn in a 3D view: drag in one": "Striche werden in einer 3D-Ansicht gezeichnet: in einer ziehen",
    "this is done by clicks in a 3D view: run it with the mouse over one": (
        "das geschieht durch Klicken in einer 3D-Ansicht: mit der Maus über einer ausführen"
    ),
    "the map has no filaments: {remedy}": "die Abbildung hat keine Fäden: {remedy}",
    "ask for more filaments, or a smaller circulation of each": (
        "mehr Fäden verlangen oder eine kleinere Zirkulation von jedem"
    ),
    "a filament of {quantum} has {share} of what passes the plane with most vorticity": (
        "ein Faden von {quantum} hat {share} dessen, was durch die Ebene mit der meisten Wirbelstärke geht"
    ),
    "{line}: with a circulation of {quantum} there are some": (
        "{line}: mit einer Zirkulation von {quantum} gibt es welche"
    ),
    "{name} is taken for the velocity (there are {have}): name another grid as the attribute": (
        "{name} gilt als die Geschwindigkeit (es gibt {have}): ein anderes Gitter als Attribut nennen"
    ),
    "the mesh is not symmetric in {axis}: {elements} lack a counterpart: symmetrize it (Mesh > "
    "Symmetrize), or switch the mirror off": (
        "das Netz ist nicht symmetrisch in {axis}: {elements} ohne Gegenstück: symmetrisieren (Netz > "
        "Symmetrisieren) oder den Spiegel ausschalten"
    ),
    "No such file or directory": "Datei oder Ordner nicht gefunden",
    "Permission denied": "keine Berechtigung",
    "Is a directory": "ist ein Ordner",
    "No space left on device": "auf dem Gerät ist kein Platz mehr",
    "it has no vectors": "es hat keine Vektoren",
    "the map does not come so near to the point's antipode: make the tubes wider, or {remedy}": (
        "die Abbildung kommt dem Gegenpunkt nicht so nahe: die Röhren weiter machen, oder {remedy}"
    ),
    "remove one of them there": "dort eine von beiden entfernen",
}

WORDS = {
    "memory": "Speicher",
    "has": "hat",
    "have": "haben",
    "meets": "trifft",
    "meet": "treffen",
    "object": "das Objekt",
    "mesh": "das Netz",
    "value": "der Wert",
    "weight": "das Gewicht",
    "degrees": "der Winkel",
    "stripe": "ein Streifen",
    "layer": "eine Schicht",
    "number": "eine Zahl",
    "none": "keines",
    "spacing": "der Abstand",
    "branching": "die Verzweigung",
    "singularities": "der Anteil der singulären Punkte",
    "seed": "der Startwert",
    "width": "die Breite",
    "radius": "der Radius",
    "smoothing": "die Glättung",
    "margin": "der Überstand",
    "samples": "die Zahl der Abtastungen",
    "resolution": "die Auflösung",
    "profile": "das Profil",
    "symmetry": "die Symmetrie",
    "guidance": "die Führung",
    "step": "der Schritt",
    "size": "die Größe",
    "height": "die Höhe",
    "depth": "die Tiefe",
    "angle": "der Winkel",
    "aspect": "das Seitenverhältnis",
    "sides": "die Zahl der Seiten",
    "faces": "die Zahl der Flächen",
    "count": "die Anzahl",
    "quantum": "die Zirkulation",
    "thickness": "die Dicke",
    "method": "das Verfahren",
    "rounding": "die Rundung",
    "boundary": "der Rand",
}
