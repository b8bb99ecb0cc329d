# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors and warnings in German: of meshes, solids, files, printing and the tasks made of them."""

SHAPES = {
    "the grid has {shape} nodes, which take about {needed} GB: give a lower resolution, or a smaller file": (
        "das Gitter hat {shape} Knoten, die etwa {needed} GB brauchen: eine niedrigere Auflösung angeben oder eine "
        "kleinere Datei"
    ),
    "{path} promises {count} faces and has {count_2} lines of vectors: it was cut short, export it again": (
        "{path} verspricht {count} Flächen und hat {count_2} Zeilen mit Vektoren: die Datei ist abgeschnitten, "
        "neu exportieren"
    ),
    "the field has {count} faces{kind} and the mesh has {triangle_count} triangles: load it on the "
    "triangle mesh that it was made for": (
        "das Feld hat {count} Flächen{kind}, und das Netz hat {triangle_count} Dreiecke: es auf das Dreiecksnetz "
        "laden, für das es gemacht wurde"
    ),
    "every vector of the field is zero or normal to its face: export the field again": (
        "jeder Vektor des Felds ist null oder steht senkrecht auf seiner Fläche: das Feld neu exportieren"
    ),
    "{path} is no known field file: use the suffix .rawfield or .rosy": (
        "{path} ist keine bekannte Felddatei: die Endung .rawfield oder .rosy verwenden"
    ),
    "{path} ends before its header: {remedy}": "{path} endet vor dem Kopf: {remedy}",
    "{path}, line {number}: {words} is no header, {remedy}": "{path}, Zeile {number}: {words} ist kein Kopf, {remedy}",
    "{path}, line {number}: {words} is not all finite numbers, correct it": (
        "{path}, Zeile {number}: {words} sind nicht lauter endliche Zahlen, berichtigen"
    ),
    "{path} cannot hold face {bad} ({count} in all), whose vectors are not equal turns of each other: "
    "write a .rawfield file": (
        "{path} kann die Fläche {bad} nicht halten (insgesamt {count}), deren Vektoren keine gleichen Drehungen "
        "voneinander sind: eine .rawfield-Datei schreiben"
    ),
    "{path} cannot be read ({strerror}): check the path": "{path} lässt sich nicht lesen ({strerror}): den Pfad prüfen",
    "{path} is not a text file: export the field again, as text": (
        "{path} ist keine Textdatei: das Feld neu exportieren, als Text"
    ),
    "{path} needs {symmetry} vectors a face and the field has one: pass it through to_vertices and "
    "from_vertices, or write a .rosy file": (
        "{path} braucht {symmetry} Vektoren je Fläche, und das Feld hat einen: es durch to_vertices und "
        "from_vertices schicken oder eine .rosy-Datei schreiben"
    ),
    "{path}, line {number}: {count} numbers where {width} are needed, three for each vector of the face": (
        "{path}, Zeile {number}: {count} Zahlen, wo {width} gebraucht werden, drei für jeden Vektor der Fläche"
    ),
    "{path}: flows are read from {choices} files": "{path}: Strömungen werden aus {choices} gelesen",
    "{path}: no such file": "{path}: diese Datei gibt es nicht",
    "{path}: has no grid of vectors (it has {have}): export the velocity": (
        "{path}: hat kein Gitter von Vektoren (es hat {have}): die Geschwindigkeit exportieren"
    ),
    "{path}: has no grid of vectors {attribute} (it has {have}): name one of these": (
        "{path}: hat kein Gitter von Vektoren {attribute} (es hat {have}): eines davon nennen"
    ),
    "{path}: has no array 'velocity' (it has {have}): save the flow under that name": (
        "{path}: hat kein Feld 'velocity' (es hat {have}): die Strömung unter diesem Namen speichern"
    ),
    "{path}: velocity holds {dtype} values: save it as floating-point numbers": (
        "{path}: velocity enthält Werte der Art {dtype}: als Gleitkommazahlen speichern"
    ),
    "{path}: {solid} has {has}: give true or false for each node of the velocity": (
        "{path}: {solid} hat {has}: für jeden Knoten der Geschwindigkeit wahr oder falsch angeben"
    ),
    "{path}: the grid {name} spans {size} voxels, more than memory holds: remove what lies far away": (
        "{path}: das Gitter {name} umspannt {size} Voxel, mehr als der Speicher fasst: entfernen, was weit weg liegt"
    ),
    "{path}: the grid {name} is empty: export a frame that has a flow": (
        "{path}: das Gitter {name} ist leer: ein Bild exportieren, das eine Strömung hat"
    ),
    "{path}: the grid {name} has voxels that are not numbers: mend the simulation": (
        "{path}: das Gitter {name} hat Voxel, die keine Zahlen sind: die Simulation berichtigen"
    ),
    "the volume {name} is scaled to nothing along an axis: give it another scale": (
        "das Volumen {name} ist entlang einer Achse auf nichts skaliert: ihm eine andere Skalierung geben"
    ),
    "{path}: {error}: write it with numpy.savez": "{path}: {error}: mit numpy.savez schreiben",
    "{path}: {name} is {has}: give {wanted}, or {axes} of them": (
        "{path}: {name} ist {has}: {wanted} angeben, oder {axes} davon"
    ),
    "{path}: reading it takes more memory than a sound file of its size: export it again": (
        "{path}: das Lesen braucht mehr Speicher als bei einer heilen Datei dieser Größe: neu exportieren"
    ),
    "{path}: {error}: choose an OpenVDB file": "{path}: {error}: eine OpenVDB-Datei wählen",
    "{path} promises more than {count} bytes hold: it was cut short, export it again": (
        "{path} verspricht mehr, als {count} Byte halten: die Datei ist abgeschnitten, neu exportieren"
    ),
    "{path} has a header that is none ({error}): export it again": (
        "{path} hat einen Kopf, der keiner ist ({error}): neu exportieren"
    ),
    "this Blender has no OpenVDB module: use another one, or flows as .npz": (
        "dieses Blender hat kein OpenVDB-Modul: ein anderes verwenden, oder Strömungen als .npz"
    ),
    "{path}: vectors in solids are read from {choices} files": (
        "{path}: Vektoren in Körpern werden aus {choices} gelesen"
    ),
    "{path} {named} (it has {have}): name one of these": "{path} {named} (es hat {have}): eines davon nennen",
    "{path} has {count} vectors for {wanted} {kind} of the solid: give one for each": (
        "{path} hat {count} Vektoren für {wanted} {kind} des Körpers: jedem einen geben"
    ),
    "{path}: vector {bad} is not finite: set its numbers": (
        "{path}: Vektor {bad} ist nicht endlich: seine Zahlen setzen"
    ),
    "{path} has an array that cannot be read ({error}): export it again": (
        "{path} hat ein Feld, das sich nicht lesen lässt ({error}): neu exportieren"
    ),
    "{path}: {keyword} cannot be read ({error}): export it again": (
        "{path}: {keyword} lässt sich nicht lesen ({error}): neu exportieren"
    ),
    "{path} is no known file of tetrahedra: use the suffix .mesh (MEDIT, text) or .vtu": (
        "{path} ist keine bekannte Datei mit Tetraedern: die Endung .mesh (MEDIT, Text) oder .vtu verwenden"
    ),
    "{path} has no tetrahedra: export the solid, not its surface": (
        "{path} hat keine Tetraeder: den Körper exportieren, nicht seine Oberfläche"
    ),
    "{path}: tetrahedron {outside} names a vertex that is not among the {count}: export it again": (
        "{path}: Tetraeder {outside} nennt einen Punkt, der nicht unter den {count} ist: neu exportieren"
    ),
    "{path} is no MEDIT file: it lacks MeshVersionFormatted, export it again": (
        "{path} ist keine MEDIT-Datei: MeshVersionFormatted fehlt, neu exportieren"
    ),
    "{path} is flat: export a solid of dimension 3": "{path} ist flach: einen Körper der Dimension 3 exportieren",
    "{path} is no MEDIT file: it lacks Vertices, export it again": (
        "{path} ist keine MEDIT-Datei: Vertices fehlt, neu exportieren"
    ),
    "{path} promises {count} {name} of {value} numbers and has {count_2} numbers: it was cut short, export it again": (
        "{path} verspricht {count} {name} zu {value} Zahlen und hat {count_2} Zahlen: die Datei ist "
        "abgeschnitten, neu exportieren"
    ),
    "{path} is no unstructured grid of VTK: export it as .vtu": (
        "{path} ist kein unstrukturiertes Gitter von VTK: als .vtu exportieren"
    ),
    "{path}: {error}": "{path}: {error}",
    "{path} is not a text file: export it as ASCII .mesh": "{path} ist keine Textdatei: als ASCII-.mesh exportieren",
    "{path} has {what}: split all cells into straight tetrahedra": (
        "{path} hat {what}: alle Zellen in gerade Tetraeder teilen"
    ),
    "{path} has something among its {what} that is no number: export it again": (
        "{path} hat unter {what} etwas, das keine Zahl ist: neu exportieren"
    ),
    "{path} has {error} among the vertices of its cells: export it again": (
        "{path} hat {error} unter den Punkten seiner Zellen: neu exportieren"
    ),
    "{path} has cells whose corners are missing: it was cut short, export it again": (
        "{path} hat Zellen, deren Ecken fehlen: die Datei ist abgeschnitten, neu exportieren"
    ),
    "{path} has tetrahedra without 4 corners, or triangles without 3: export it again": (
        "{path} hat Tetraeder ohne 4 Ecken oder Dreiecke ohne 3: neu exportieren"
    ),
    "{path} is no XML file ({error}): export it again": "{path} ist keine XML-Datei ({error}): neu exportieren",
    "{path}: cannot be written ({reason}): make room, or choose another place": (
        "{path}: lässt sich nicht schreiben ({reason}): Platz schaffen oder einen anderen Ort wählen"
    ),
    "the surface is one-sided at {where}: cut it open along a loop of edges (Mesh > Split)": (
        "die Oberfläche ist an {where} einseitig: sie entlang einer Schleife von Kanten aufschneiden (Netz > Teilen)"
    ),
    "the mesh is empty: add some geometry first": "das Netz ist leer: zuerst Geometrie hinzufügen",
    "the mesh has no faces: a field lives on faces, so fill the outline (F) first": (
        "das Netz hat keine Flächen: ein Feld lebt auf Flächen, also zuerst den Umriss füllen (F)"
    ),
    "the edge between vertices {i} and {j} has {edge_face_counts} faces{piece}: keep two, see Select > All"
    " by Trait > Non Manifold": (
        "die Kante zwischen den Punkten {i} und {j} hat {edge_face_counts} Flächen{piece}: zwei behalten, siehe "
        "Auswählen > Alle nach Eigenschaft > Nicht mannigfaltig"
    ),
    "{where} face opposite ways: use Mesh > Normals > Recalculate Outside": (
        "{where} sind entgegengesetzt orientiert: Netz > Normalen > Außenseite neu berechnen verwenden"
    ),
    "{area} holds no whole face: assign all vertices of at least one face to it": (
        "{area} enthält keine ganze Fläche: alle Punkte mindestens einer Fläche zuweisen"
    ),
    "the tetrahedra's size is {size}: give a positive length": (
        "die Größe der Tetraeder ist {size}: eine positive Länge angeben"
    ),
    "a size of {size} makes about {expected}: give one from {smallest} on": (
        "eine Größe von {size} macht etwa {expected}: eine ab {smallest} angeben"
    ),
    "the spacing {finest} is finer than tetrahedra of size {size} can carry: give a size of {value}, or a "
    "spacing from {value_2} on": (
        "der Abstand {finest} ist feiner, als Tetraeder der Größe {size} tragen können: eine Größe von {value} "
        "oder einen Abstand ab {value_2} angeben"
    ),
    "the spacing {spacing} is larger than the object ({reach}): no layer would fit, reduce it": (
        "der Abstand {spacing} ist größer als das Objekt ({reach}): keine Schicht hätte Platz, verringern Sie ihn"
    ),
    "tetrahedra of size {size} are too large for the thin parts of the surface: {flaw}, and up to "
    "{most_tried} smaller ones would not do: thicken these parts, or give a size below {finer}": (
        "Tetraeder der Größe {size} sind zu groß für die dünnen Teile der Oberfläche: {flaw}, und bis zu "
        "{most_tried} kleinere täten es auch nicht: diese Teile verdicken oder eine Größe unter {finer} angeben"
    ),
    "tetrahedra of size {size} are too large: {flaw}; give a size of {finer}, which makes about {count} of them": (
        "Tetraeder der Größe {size} sind zu groß: {flaw}; eine Größe von {finer} angeben, die etwa {count} davon macht"
    ),
    "a size of {size} makes no tetrahedra: choose a positive length": (
        "eine Größe von {size} macht keine Tetraeder: eine positive Länge wählen"
    ),
    "a size of {size} makes {cubes} cubes: choose one above {fitting}": (
        "eine Größe von {size} macht {cubes} Würfel: eine über {fitting} wählen"
    ),
    "the surface leaves the bounds: make it closed, with its faces outwards, and give its box": (
        "die Oberfläche verlässt ihre Grenzen: sie schließen, mit den Flächen nach außen, und ihren Kasten angeben"
    ),
    "the edge between vertices {i} and {j} has one face only, and a solid needs a closed surface: fill the"
    " holes with Mesh > Clean Up > Fill Holes": (
        "die Kante zwischen den Punkten {i} und {j} hat nur eine Fläche, und ein Körper braucht eine geschlossene"
        " Oberfläche: die Löcher füllen mit Netz > Aufräumen > Löcher füllen"
    ),
    "a grid of {dimension} axes: give it two or three": "ein Gitter mit {dimension} Achsen: zwei oder drei geben",
    "the grid's spacing is {spacing}: give positive lengths": (
        "der Abstand des Gitters ist {spacing}: positive Längen angeben"
    ),
    "{count} nodes along axis {value}: a grid needs {fewest} at least there": (
        "{count} Knoten entlang der Achse {value}: ein Gitter braucht dort mindestens {fewest}"
    ),
    "obstacles leave no cell of the grid open: leave room for the flow": (
        "Hindernisse lassen keine Zelle des Gitters offen: der Strömung Platz lassen"
    ),
    "there are no faces to find the nearest points on: add some": (
        "es gibt keine Flächen, auf denen die nächsten Punkte liegen könnten: welche hinzufügen"
    ),
    "{what} has points without a finite place: set their coordinates, or delete them": (
        "{what} hat Punkte ohne endlichen Ort: ihre Koordinaten setzen oder sie löschen"
    ),
    "{what} has a length of {length}, and no more than {value} can be followed along this mesh: delete the"
    " points that are far away from it": (
        "{what} hat eine Länge von {length}, und entlang dieses Netzes lassen sich höchstens {value} verfolgen: "
        "die Punkte löschen, die weit davon weg sind"
    ),
    "the solid has no tetrahedra: a field in a solid needs one at least": (
        "der Körper hat keine Tetraeder: ein Feld in einem Körper braucht mindestens eines"
    ),
    "tetrahedron {outside} has the vertices {tets} and there are {count}: count them from 0": (
        "Tetraeder {outside} hat die Punkte {tets}, und es gibt {count}: ab 0 zählen"
    ),
    "{elements} {verb} no finite position: set the coordinates": (
        "{elements} {verb} keinen endlichen Ort: die Koordinaten setzen"
    ),
    "the triangle of vertices {choices} has {many} tetrahedra (one is {value}): remove those that overlap": (
        "das Dreieck der Punkte {choices} hat {many} Tetraeder (eines ist {value}): die entfernen, die sich überlappen"
    ),
    "triangle {face} has the vertices {triangles} and there are {count}: count them from 0": (
        "Dreieck {face} hat die Punkte {triangles}, und es gibt {count}: ab 0 zählen"
    ),
    "{path}: a machine's file must end in {suffix}": "{path}: die Datei einer Maschine muss auf {suffix} enden",
    "the largest_height is {largest_height}: give more than the smallest_height": (
        "die größte Höhe (largest_height) ist {largest_height}: mehr als die kleinste (smallest_height) angeben"
    ),
    "{path}: cannot be read ({strerror}): choose another file": (
        "{path}: lässt sich nicht lesen ({strerror}): eine andere Datei wählen"
    ),
    "{path}: cannot be read ({error}): write lines such as feed = 1200": (
        "{path}: lässt sich nicht lesen ({error}): Zeilen wie feed = 1200 schreiben"
    ),
    "the {setting} is {value}: give a finite number": "{setting} ist {value}: eine endliche Zahl angeben",
    "the {setting} is {value}: give a number from 0 on": "{setting} ist {value}: eine Zahl ab 0 angeben",
    "the {setting} is {value}: give degrees from 0 to below 90": (
        "{setting} ist {value}: Grad von 0 bis unter 90 angeben"
    ),
    "a frame starts from the relaxation of the one before: use the method sdp": (
        "ein Bild beginnt mit der Relaxation des vorigen: das Verfahren sdp verwenden"
    ),
    "no frame has vorticity: there are no vortices to show": (
        "kein Bild hat Wirbelstärke: es gibt keine Wirbel zu zeigen"
    ),
    "{path}: its grid is not that of {name}: all frames need the same": (
        "{path}: das Gitter ist nicht das von {name}: alle Bilder brauchen dasselbe"
    ),
    "the opening is {opening} degrees: the whole sphere has 180, give less": (
        "die Öffnung ist {opening} Grad: die ganze Kugel hat 180, weniger angeben"
    ),
    "tubes and points of the sphere come from the relaxation: use the method sdp": (
        "Röhren und Punkte der Kugel kommen aus der Relaxation: das Verfahren sdp verwenden"
    ),
    "the frames are {frames}: give the first and the last one, whole numbers": (
        "die Bilder sind {frames}: das erste und das letzte angeben, ganze Zahlen"
    ),
    "the frames {first} to {last} are none: give the first one first": (
        "die Bilder {first} bis {last} sind keine: das erste zuerst angeben"
    ),
    "the point of the sphere is {point}: give three numbers that are not all 0": (
        "der Punkt der Kugel ist {point}: drei Zahlen angeben, die nicht alle 0 sind"
    ),
    "{mean} filaments pass a face of the grid on average, and from {most_quanta} on they cannot be told "
    "apart: give a circulation from {value} on, or a finer grid": (
        "im Mittel gehen {mean} Fäden durch eine Fläche des Gitters, und ab {most_quanta} lassen sie sich nicht "
        "trennen: eine Zirkulation ab {value} oder ein feineres Gitter angeben"
    ),
    "the circulation of a filament is spread over {faces} faces of the grid, and tubes have an inside from"
    " about {faces_of_tubes} on: give a finer grid, {remedy}": (
        "die Zirkulation eines Fadens verteilt sich auf {faces} Flächen des Gitters, und Röhren haben ab etwa "
        "{faces_of_tubes} ein Inneres: ein feineres Gitter angeben, {remedy}"
    ),
    "tubes have an inside from a core of {core_of_tubes} cells on, and it is {cells}: increase the core, {remedy}": (
        "Röhren haben ab einem Kern von {core_of_tubes} Zellen ein Inneres, und es sind {cells}: den Kern "
        "vergrößern, {remedy}"
    ),
    "a resolution of {resolution} nodes shows no vortex: give a whole number from 8 on": (
        "eine Auflösung von {resolution} Knoten zeigt keinen Wirbel: eine ganze Zahl ab 8 angeben"
    ),
    "{name}: a flow in a plane has no filaments to show: give one in space": (
        "{name}: eine Strömung in einer Ebene hat keine Fäden zu zeigen: eine im Raum angeben"
    ),
    "frame {number}: {error}": "Bild {number}: {error}",
    "no path of the step {step} fits on a layer: reduce it": (
        "keine Bahn im Schritt {step} passt auf eine Schicht: ihn verringern"
    ),
    "a resolution of {resolution} makes {count} voxels, and {most_voxels} is the most: reduce it to {fitting}": (
        "eine Auflösung von {resolution} macht {count} Voxel, und mehr als {most_voxels} dürfen es nicht sein: "
        "auf {fitting} verringern"
    ),
    "the quad mesh has {count} faces, not {wanted}: what it must keep to leaves no spacing nearer to that": (
        "das Vierecksnetz hat {count} Flächen, nicht {wanted}: was es einhalten muss, lässt keinen Abstand, der "
        "näher daran wäre"
    ),
    "the quad mesh has {count} faces, not {wanted}: each of the {pieces} pieces of the surface has one of its "
    "own: where they should hang together, use Mesh > Clean Up > Merge by Distance": (
        "das Vierecksnetz hat {count} Flächen, nicht {wanted}: jedes der {pieces} Stücke der Oberfläche hat eine "
        "eigene: wo sie zusammenhängen sollten, Netz > Aufräumen > Nach Abstand verschmelzen benutzen"
    ),
    "{count} of {count_2} pieces of the surface are too small for the quads and left out: reduce the spacing": (
        "{count} von {count_2} Stücken der Oberfläche sind zu klein für die Vierecke und fehlen: den Abstand verringern"
    ),
    "an internal fault made {what} for {name}: nothing was written, please report it with the file": (
        "ein innerer Fehler machte {what} für {name}: es wurde nichts geschrieben, bitte mit der Datei melden"
    ),
    "{count} of {count_2} lines of the boundary and of sharp edges are lost, {lost} of {lengths} in "
    "length: reduce the spacing": (
        "{count} von {count_2} Linien des Rands und scharfer Kanten sind verloren, {lost} von {lengths} der "
        "Länge: den Abstand verringern"
    ),
    "{others} of {faces} faces are no quads though no branches are asked for: reduce the spacing": (
        "{others} von {faces} Flächen sind keine Vierecke, obwohl keine Verzweigungen verlangt sind: den Abstand "
        "verringern"
    ),
    "{faces} faces are too few for a quad mesh of this surface: ask for more": (
        "{faces} Flächen sind zu wenig für ein Vierecksnetz dieser Oberfläche: mehr verlangen"
    ),
    "the spacing is finer than the solid can carry on {coarse_share} of its edges: increase it, or make "
    "the solid of smaller tetrahedra": (
        "der Abstand ist auf {coarse_share} der Kanten feiner, als der Körper tragen kann: ihn vergrößern oder "
        "den Körper aus kleineren Tetraedern machen"
    ),
    "the solid lacks {lost} of the surface's volume: what is thinner than {size} is lost, reduce the size "
    "of its tetrahedra": (
        "dem Körper fehlen {lost} des Volumens der Oberfläche: was dünner als {size} ist, geht verloren, die "
        "Größe seiner Tetraeder verringern"
    ),
    "the solid {flaw}: reduce the size of its tetrahedra, {size}": (
        "der Körper {flaw}: die Größe seiner Tetraeder verringern, {size}"
    ),
    "{share} of {area} is farther than {far} spacings from the layers: reduce the size of the tetrahedra, {size}": (
        "{share} von {area} liegen weiter als {far} Abstände von den Schichten: die Größe der Tetraeder "
        "verringern, {size}"
    ),
    "{label} has no direction of its own in {continued} of the solid, where those around go on: reduce the"
    " size of its tetrahedra, {size}": (
        "{label} hat in {continued} des Körpers keine eigene Richtung, dort setzen sich die umliegenden fort: die"
        " Größe seiner Tetraeder verringern, {size}"
    ),
    "in {outside} of the solid layers end, or are not between {limits} high: give limits that are farther "
    "apart, or another spacing": (
        "in {outside} des Körpers enden Schichten oder sind nicht zwischen {limits} hoch: Grenzen angeben, die "
        "weiter auseinander liegen, oder einen anderen Abstand"
    ),
    "the solid's triangles cover {covered} of {area}, where they do not cut off its rim: tetrahedra of a "
    "size of about {finer} would do": (
        "die Dreiecke des Körpers bedecken {covered} von {area}, wo sie seinen Rand nicht abschneiden: Tetraeder "
        "einer Größe von etwa {finer} täten es"
    ),
}
