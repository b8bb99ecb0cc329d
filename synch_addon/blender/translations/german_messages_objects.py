# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors and warnings in German: of the file's objects, baking, flows, frames and jobs."""

OBJECTS = {
    "{count} numbers are more than a PNG holds: they start again after {most}": (
        "{count} Nummern sind mehr, als ein PNG fasst: nach {most} fangen sie neu an"
    ),
    "the variation is {number}: give a whole number from 0 to {most_variations}": (
        "die Variante ist {number}: eine ganze Zahl von 0 bis {most_variations} angeben"
    ),
    "defects are placed in stripes and quads: solve one of them first": (
        "Defekte werden in Streifen und Vierecke gesetzt: lösen Sie zuerst eines davon"
    ),
    "{name} shows no quads: solve quads first": "{name} zeigt keine Vierecke: zuerst Vierecke lösen",
    "{outside} of the corners lie outside the image in the UV map {name}": (
        "{outside} der Ecken liegen in der UV-Map {name} außerhalb des Bilds"
    ),
    "faces overlap in the UV map {name}: one image cannot show them all": (
        "in der UV-Map {name} überlappen sich Flächen: ein Bild kann nicht alle zeigen"
    ),
    "Cycles is switched off: enable Cycles Render Engine in Preferences > Add-ons": (
        "Cycles ist ausgeschaltet: die Cycles Render Engine unter Einstellungen > Add-ons einschalten"
    ),
    "{given}: this folder lies beside the .blend: save that first, or choose another folder": (
        "{given}: dieser Ordner liegt neben der .blend-Datei: zuerst diese speichern oder einen anderen Ordner wählen"
    ),
    "{given}: this folder does not exist, create it first": "{given}: diesen Ordner gibt es nicht, zuerst anlegen",
    "{given}: nothing can be written to this folder, choose another": (
        "{given}: in diesen Ordner lässt sich nichts schreiben, einen anderen wählen"
    ),
    "the mesh {name} has no {which}: choose one of its maps ({present}), or ask for Smart UV Project": (
        "das Netz {name} hat keine {which}: eine seiner UV-Maps wählen ({present}), oder Smart UV Project verlangen"
    ),
    "the mesh {name} has another attribute {name_2}: give the UV map another name": (
        "das Netz {name} hat ein anderes Attribut {name_2}: der UV-Map einen anderen Namen geben"
    ),
    "the mesh {name} has {most_maps} UV maps, which is the most: remove one": (
        "das Netz {name} hat {most_maps} UV-Maps, mehr gehen nicht: eine entfernen"
    ),
    "the UV map {name} of {name_2} is empty: unwrap the mesh, or ask for a new map": (
        "die UV-Map {name} von {name_2} ist leer: das Netz abwickeln oder eine neue UV-Map verlangen"
    ),
    "{path}: this is a folder, choose another name": "{path}: das ist ein Ordner, einen anderen Namen wählen",
    "the maps are {names}: give names such as colour,normal": (
        "die Bilder sind {names}: Namen wie colour,normal angeben"
    ),
    "no map is asked for: choose one or more of {choices}": (
        "kein Bild ist verlangt: eines oder mehrere von {choices} wählen"
    ),
    "a material shows colour, normal or height: add one of them to the maps": (
        "ein Material zeigt Farbe, Normale oder Höhe: eines davon hinzufügen"
    ),
    "displacement is made by a material of the height: ask for both": (
        "Verschiebung macht ein Material der Höhe: beides verlangen"
    ),
    "the name {naming} cannot be filled in: use letters, {{object}} and {{map}}": (
        "der Name {naming} lässt sich nicht ausfüllen: Buchstaben, {{object}} und {{map}} verwenden"
    ),
    "the name {naming} is the same for {count} maps: add {{map}}": (
        "der Name {naming} ist derselbe für {count} Bilder: {{map}} hinzufügen"
    ),
    "the map {name} is unknown: use one or more of {choices}": (
        "das Bild {name} gibt es nicht: eines oder mehrere von {choices} verwenden"
    ),
    "the {setting} is {value}: give a whole number from {low} to {high}": (
        "{setting} ist {value}: eine ganze Zahl von {low} bis {high} angeben"
    ),
    "the node group {name} has no output {name_2}: solve the pattern again": (
        "die Node-Gruppe {name} hat keinen Ausgang {name_2}: das Muster neu lösen"
    ),
    "Cycles cannot bake {name}: {first_line}": "Cycles kann {name} nicht backen: {first_line}",
    "the mesh {name} has no {which}: choose one of its maps ({present}), or unwrap it": (
        "das Netz {name} hat keine {which}: eine seiner UV-Maps wählen ({present}), oder es abwickeln"
    ),
    "the mesh {name} has no attribute {name_2}: choose a {kind} attribute ({have})": (
        "das Netz {name} hat kein Attribut {name_2}: ein Attribut der Art {kind} wählen ({have})"
    ),
    "the attribute {name} is {data_type} on {domain}: it must be a {kind} on points": (
        "das Attribut {name} ist {data_type} auf {domain}: es muss der Art {kind} sein und auf Punkten liegen"
    ),
    "{elements} has more than three corners and a field file has directions for triangles only: "
    "triangulate the mesh with Face > Triangulate Faces": (
        "{elements} hat mehr als drei Ecken, und eine Felddatei hat Richtungen nur für Dreiecke: das Netz "
        "triangulieren mit Fläche > Flächen triangulieren"
    ),
    "{path} has {symmetry} directions a face: import fields of 1, 2 or 4": (
        "{path} hat {symmetry} Richtungen je Fläche: Felder mit 1, 2 oder 4 importieren"
    ),
    "{path}: files of the kind {suffix} cannot be read: use .blend, {choices}": (
        "{path}: Dateien der Art {suffix} lassen sich nicht lesen: .blend, {choices} verwenden"
    ),
    "there is no object {name}: choose one of {choices}": "es gibt kein Objekt {name}: eines von {choices} wählen",
    "{path}: the name of this output must end in {choices}": "{path}: der Name dieser Ausgabe muss auf {choices} enden",
    "{path}: its folder does not exist, create it first": "{path}: den Ordner gibt es nicht, zuerst anlegen",
    "{path}: cannot be read ({reason}): export it again": "{path}: lässt sich nicht lesen ({reason}): neu exportieren",
    "there is no mesh object {name}: choose one of {choices}": (
        "es gibt kein Netzobjekt {name}: eines von {choices} wählen"
    ),
    "the file has no mesh object: a field needs the faces of a mesh": (
        "die Datei hat kein Netzobjekt: ein Feld braucht die Flächen eines Netzes"
    ),
    "the vertex group {name} is empty: assign vertices to it": "die Punktgruppe {name} ist leer: ihr Punkte zuweisen",
    "{name} has no vertex group {name_2}: choose one of its groups ({names})": (
        "{name} hat keine Punktgruppe {name_2}: eine seiner Gruppen wählen ({names})"
    ),
    "{name} is not a mesh: select a mesh object, or convert it with Object > Convert": (
        "{name} ist kein Netz: ein Netzobjekt auswählen oder es umwandeln mit Objekt > Umwandeln"
    ),
    "the {kind} {name} is linked: make it local with Object > Relations > Make Local": (
        "{kind} {name} ist verknüpft: lokal machen mit Objekt > Beziehungen > Lokal machen"
    ),
    "the transform of {name} is not finite: clear it with Object > Clear": (
        "die Transformation von {name} ist nicht endlich: sie zurücksetzen mit Objekt > Zurücksetzen"
    ),
    "the scale of {name} is zero along an axis: give it a scale in every direction": (
        "die Skalierung von {name} ist entlang einer Achse null: eine Skalierung in jeder Richtung geben"
    ),
    "faces of {name} were deleted since its defects were found: solve it again": (
        "Flächen von {name} wurden gelöscht, seit seine Defekte gefunden wurden: neu lösen"
    ),
    "{name} is in edit mode and not active: make it the active object, or leave edit mode": (
        "{name} ist im Bearbeitungsmodus und nicht aktiv: es zum aktiven Objekt machen oder den Bearbeitungsmodus"
        " verlassen"
    ),
    "the vertex group {name} of {name_2} has a name of our attributes: rename it": (
        "die Punktgruppe {name} von {name_2} heißt wie eines unserer Attribute: sie umbenennen"
    ),
    "no active object: select a mesh object": "kein aktives Objekt: ein Netzobjekt auswählen",
    "{obj} is no object: give one of bpy.data.objects": "{obj} ist kein Objekt: eines von bpy.data.objects angeben",
    "the object is gone: it was removed from the file": "das Objekt ist weg: es wurde aus der Datei entfernt",
    "the object {name} is gone: nothing was written": "das Objekt {name} ist weg: nichts wurde geschrieben",
    "there is no curve object {name}: choose a curve or Grease Pencil object of the scene": (
        "es gibt kein Kurvenobjekt {name}: eine Kurve oder ein Grease-Pencil-Objekt der Szene wählen"
    ),
    "the object {name} is a {kind}: choose a curve or Grease Pencil object": (
        "das Objekt {name} ist der Art {kind}: eine Kurve oder ein Grease-Pencil-Objekt wählen"
    ),
    "the object {name} holds no curve: draw one, or choose another object": (
        "das Objekt {name} enthält keine Kurve: eine zeichnen oder ein anderes Objekt wählen"
    ),
    "the attribute {name} of {name_2} is of no use at {elements}: give {wanted}": (
        "das Attribut {name} von {name_2} taugt nichts an {elements}: {wanted} angeben"
    ),
    "the volume {name} has no file: save it as .vdb and choose that": (
        "das Volumen {name} hat keine Datei: als .vdb speichern und diese wählen"
    ),
    "frame {frame} lies outside the sequence of {name}: choose frames that it has": (
        "Bild {frame} liegt außerhalb der Folge {name}: Bilder wählen, die sie hat"
    ),
    "{path}: has no number in its name: choose the first file of a sequence": (
        "{path}: hat keine Nummer im Namen: die erste Datei einer Folge wählen"
    ),
    "{name} is being edited: leave its edit mode": "{name} wird gerade bearbeitet: den Bearbeitungsmodus verlassen",
    "nothing has a flow: choose a file, a volume, a mesh, or curves that stand for filaments": (
        "nichts hat eine Strömung: eine Datei, ein Volumen, ein Netz oder Kurven wählen, die für Wirbelfäden stehen"
    ),
    "{path}: mark where the number of a frame stands, such as smoke_####.vdb": (
        "{path}: kennzeichnen, wo die Nummer eines Bilds steht, etwa smoke_####.vdb"
    ),
    "frames are solved of numbered files and of volumes with a sequence: choose one of these": (
        "Bilder werden aus nummerierten Dateien und aus Volumen mit einer Folge gelöst: eines davon wählen"
    ),
    "{path}: no such file: frame {frame} of the sequence is missing": (
        "{path}: diese Datei gibt es nicht: Bild {frame} der Folge fehlt"
    ),
    "the volume {name} is no sequence: open its files as one, or solve it as it is": (
        "das Volumen {name} ist keine Folge: seine Dateien als eine öffnen, oder es lösen, wie es ist"
    ),
    "{source} is no flow: give a file, a volume, a mesh, or curves that stand for filaments": (
        "{source} ist keine Strömung: eine Datei, ein Volumen, ein Netz oder Kurven angeben, die für Wirbelfäden stehen"
    ),
    "there is no curve with two points: draw the vortex filaments": (
        "es gibt keine Kurve mit zwei Punkten: die Wirbelfäden zeichnen"
    ),
    "{name} is no curve: choose curves, a volume, or a .vdb or .npz file": (
        "{name} ist keine Kurve: Kurven, ein Volumen oder eine .vdb- oder .npz-Datei wählen"
    ),
    "{name}: its {attribute} is {value}: give the circulation as a number": (
        "{name}: {attribute} ist {value}: die Zirkulation als Zahl angeben"
    ),
    "the mesh {name} has changed since its flow was read: run it again": (
        "das Netz {name} hat sich geändert, seit seine Strömung gelesen wurde: noch einmal ausführen"
    ),
    "{name} is a surface with a flow of its own: choose it alone": (
        "{name} ist eine Oberfläche mit eigener Strömung: sie allein wählen"
    ),
    "the frames are {frames}: give the first and the last one": (
        "die Bilder sind {frames}: das erste und das letzte angeben"
    ),
    "frame {frame}: the modifier {modifier} of {name} changes its faces: hide it in the viewport while the"
    " animation is solved, or apply it": (
        "Bild {frame}: der Modifikator {modifier} von {name} ändert die Flächen: ihn in der Ansicht ausblenden, "
        "solange die Animation gelöst wird, oder ihn anwenden"
    ),
    "the frames are {first} to {last}: give the first and the last, in order": (
        "die Bilder sind {first} bis {last}: das erste und das letzte in dieser Reihenfolge angeben"
    ),
    "the hold is {hold}: give a number from 0 on, such as {hold_2}": (
        "der Halt ist {hold}: eine Zahl ab 0 angeben, etwa {hold_2}"
    ),
    "the mesh or the scale of {name} changed while it was solved: run again": (
        "das Netz oder die Skalierung von {name} änderte sich während des Lösens: noch einmal ausführen"
    ),
    "{name} is being solved: wait for it, or cancel it": "{name} wird gerade gelöst: warten oder abbrechen",
    "there is not enough memory for the result: use a coarser mesh, or close other programs": (
        "für das Ergebnis ist nicht genug Speicher da: ein gröberes Netz verwenden oder andere Programme schließen"
    ),
    "{elements} without a face get no field: remove loose geometry with Mesh > Clean Up > Delete Loose": (
        "{elements} ohne Fläche bekommen kein Feld: lose Geometrie entfernen mit Netz > Aufräumen > Lose löschen"
    ),
    "directions that an attribute gives are taken as they are, without {rows}: give it a strength "
    "(attribute:{exact_attribute}=1) where rows should turn them": (
        "Richtungen aus einem Attribut werden genommen, wie sie sind, ohne {rows}: ihm eine Stärke geben "
        "(attribute:{exact_attribute}=1), wo Zeilen sie drehen sollen"
    ),
    "phases of {rows} are meant for the directions that they were written with: guide by "
    "attribute:synch_direction without a strength": (
        "Phasen von {rows} sind für die Richtungen gemeint, mit denen sie geschrieben wurden: durch "
        "attribute:synch_direction ohne Stärke führen"
    ),
    "the angle turns directions away from lines with a stripe ({rows}): set it to 0": (
        "der Winkel dreht Richtungen von Linien mit einem Streifen weg ({rows}): ihn auf 0 setzen"
    ),
    "directions that an attribute gives are taken as they are, without the mirror: give it a strength "
    "(attribute:{exact_attribute}=1) where they should be mirrored": (
        "Richtungen aus einem Attribut werden genommen, wie sie sind, ohne den Spiegel: ihm eine Stärke geben "
        "(attribute:{exact_attribute}=1), wo sie gespiegelt werden sollen"
    ),
    "directions that an attribute gives are taken as they are, with all their singular points: give it a "
    "strength (attribute:{exact_attribute}=1) where there should be fewer": (
        "Richtungen aus einem Attribut werden genommen, wie sie sind, mit allen singulären Punkten: ihm eine "
        "Stärke geben (attribute:{exact_attribute}=1), wo es weniger sein sollen"
    ),
    "directions that an attribute gives are taken as they are, without the pins: give it a strength": (
        "Richtungen aus einem Attribut werden genommen, wie sie sind, ohne die festgesetzten Punkte: ihm eine "
        "Stärke geben"
    ),
    "the angle turns directions the same way on both sides of the mirror: set it to 0": (
        "der Winkel dreht Richtungen auf beiden Seiten des Spiegels gleich herum: ihn auf 0 setzen"
    ),
    "{solved} solved on the mesh before its modifiers ({names}): apply them first to solve on their result": (
        "{solved} auf dem Netz vor seinen Modifikatoren gelöst ({names}): sie zuerst anwenden, um auf ihrem "
        "Ergebnis zu lösen"
    ),
    "the mesh {name} is shared by {users} users, which all get {what}": (
        "das Netz {name} teilen sich {users} Benutzer, die alle {what} bekommen"
    ),
    "{name} has no solve in memory ({kept}): solve it first": (
        "{name} hat keine Lösung im Speicher ({kept}): zuerst lösen"
    ),
    "the process that solves cannot be started: {command}: {strerror}": (
        "der Prozess, der löst, lässt sich nicht starten: {command}: {strerror}"
    ),
    "the process that solves said what is no message ({error}): run again": (
        "der Prozess, der löst, sagte etwas, das keine Nachricht ist ({error}): noch einmal ausführen"
    ),
    "the process that solves has another {name} than Blender ({there}, not {here})": (
        "der Prozess, der löst, hat ein anderes {name} als Blender ({there}, nicht {here})"
    ),
    "the preset {name} is unknown: use one of {choices}": (
        "die Vorgabe {name} gibt es nicht: eine von {choices} verwenden"
    ),
    "cannot write a picture to {name}: use one of {choices}": (
        "nach {name} lässt sich kein Bild schreiben: eines von {choices} verwenden"
    ),
    "{name} has no faces to render": "{name} hat keine Flächen zu rendern",
    "there is no 3D view to turn: run this in one": "es gibt keine 3D-Ansicht zu drehen: in einer ausführen",
    "{name} has no such place any more: solve it again": "{name} hat keine solche Stelle mehr: neu lösen",
    "{name} has no quads: loops are rows of quads": "{name} hat keine Vierecke: Schleifen sind Reihen von Vierecken",
    "no loop passes through this edge: it has no quad beside it": (
        "durch diese Kante geht keine Schleife: kein Viereck liegt daneben"
    ),
    "the object {object_name} is gone: nothing more can be done on it": (
        "das Objekt {object_name} ist weg: daran lässt sich nichts mehr tun"
    ),
}
