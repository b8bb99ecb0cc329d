# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors and warnings in German: of patterns, their settings and layers on an object."""

PATTERNS = {
    "the guidance {kind} is unknown: use one of {choices}": (
        "die Führung {kind} gibt es nicht: eine von {choices} verwenden"
    ),
    "symmetry {symmetry} is unknown: use one of {choices}": (
        "die Symmetrie {symmetry} gibt es nicht: eine von {choices} verwenden"
    ),
    "{name} has no stripes or quads: solve one of them first": (
        "{name} hat keine Streifen oder Vierecke: lösen Sie zuerst eines davon"
    ),
    "{name} shows no stripes or quads: solve them first": (
        "{name} zeigt keine Streifen oder Vierecke: lösen Sie sie zuerst"
    ),
    "the pattern of {name} has cuts, which attributes of vertices cannot tell: use the seed": (
        "das Muster von {name} hat Schnitte, die Attribute von Punkten nicht sagen können: den Startwert verwenden"
    ),
    "{name} has no favourite {name_2}: choose one of its own ({names})": (
        "{name} hat keinen Favoriten {name_2}: einen der eigenen wählen ({names})"
    ),
    "attributes of the pattern of {name} are missing: solve it again": (
        "Attribute des Musters von {name} fehlen: neu lösen"
    ),
    "no line of the pattern lies on {name}: reduce the spacing and solve again": (
        "keine Linie des Musters liegt auf {name}: den Abstand verringern und neu lösen"
    ),
    "the width is {width}: give a part of a period from 0 (middles) to 1 (of gaps)": (
        "die Breite ist {width}: einen Teil einer Periode von 0 (Mitten) bis 1 (der Lücken) angeben"
    ),
    "live settings cut no edges and change no symmetry: solve again": (
        "Live-Einstellungen schneiden keine Kanten und ändern keine Symmetrie: neu lösen"
    ),
    "what {name} shows is no longer in memory: solve it again": (
        "was {name} zeigt, ist nicht mehr im Speicher: neu lösen"
    ),
    "the mesh or the scale of {name} has changed since it was solved: solve it again": (
        "das Netz oder die Skalierung von {name} hat sich seit dem Lösen geändert: neu lösen"
    ),
    "the mesh {name} shows another pattern than {name_2} was given: solve it again": (
        "das Netz {name} zeigt ein anderes Muster, als {name_2} bekam: neu lösen"
    ),
    "no stripe has its middle on {name}: reduce the spacing and solve again": (
        "kein Streifen hat seine Mitte auf {name}: den Abstand verringern und neu lösen"
    ),
    "stripes are numbered: solve stripes first": "nummeriert werden Streifen: zuerst Streifen lösen",
    "the pattern of {name} is of a newer Synch Fields (format {found}, this one reads up to {format}): "
    "update the extension, or solve it again": (
        "das Muster von {name} ist von neueren Synch-Feldern (Format {found}, diese lesen bis {format}): die "
        "Erweiterung aktualisieren oder neu lösen"
    ),
    "{name} has no pattern whose settings are known: solve stripes or quads on it first": (
        "{name} hat kein Muster, dessen Einstellungen bekannt sind: zuerst Streifen oder Vierecke darauf lösen"
    ),
    "the pattern of {name} has cuts, which its attributes cannot tell: solve it again": (
        "das Muster von {name} hat Schnitte, die seine Attribute nicht sagen können: neu lösen"
    ),
    "lines are drawn of stripes and quads: solve one of them first": (
        "Linien werden von Streifen und Vierecken gezeichnet: zuerst eines davon lösen"
    ),
    "{label} gives one phase a vertex, and quads have two: remove the row": (
        "{label} gibt einem Punkt eine Phase, und Vierecke haben zwei: die Zeile entfernen"
    ),
    "the level is {levels}: give a whole number from 1 to {most_levels}": (
        "die Stufe ist {levels}: eine ganze Zahl von 1 bis {most_levels} angeben"
    ),
    "{name} has no faces: add some first": "{name} hat keine Flächen: zuerst welche hinzufügen",
    "level {levels} would make {faces_after} faces: take a lower one": (
        "Stufe {levels} gäbe {faces_after} Flächen: eine niedrigere nehmen"
    ),
    "{name} cannot be subdivided: {value}": "{name} lässt sich nicht unterteilen: {value}",
    "the profile {profile} is unknown: use one of {choices}": (
        "das Profil {profile} gibt es nicht: eines von {choices} verwenden"
    ),
    "the {setting} is {value}: give a number{between}": "{setting} ist {value}: eine Zahl angeben{between}",
    "the {setting} is {value}: give a whole number from 0 to {most}": (
        "{setting} ist {value}: eine ganze Zahl von 0 bis {most} angeben"
    ),
    "{count} faces with a defect were split into triangles, first face {faces}: corner values carry one "
    "disclination, or two dislocations, in at most four corners": (
        "{count} Flächen mit einem Defekt wurden in Dreiecke geteilt, zuerst Fläche {faces}: Werte an Ecken "
        "tragen eine Disklination oder zwei Versetzungen in höchstens vier Ecken"
    ),
    "{count} defects, and an empty for none of them (from {most_empties} on Blender takes long for each): "
    "the overlay draws them, the report lists them": (
        "{count} Defekte, und für keinen ein Leerobjekt (ab {most_empties} braucht Blender für jedes lange): die "
        "Einblendung zeichnet sie, der Bericht zählt sie auf"
    ),
    "the constraints are no list: give a list of rows such as {{'where': 'seams', 'what': 'cut'}}": (
        "die Bedingungen sind keine Liste: eine Liste von Zeilen angeben wie {{'where': 'seams', 'what': 'cut'}}"
    ),
    "{label} holds no edge: {remedy}, or remove the row": (
        "{label} enthält keine Kante: {remedy}, oder die Zeile entfernen"
    ),
    "{label} holds nowhere: give one vertex at least a {kind}, or remove the row": (
        "{label} hält nirgends: mindestens einem Punkt {kind} geben, oder die Zeile entfernen"
    ),
    "the name {name} in {where} {what} is no text: give a name": (
        "der Name {name} in {where} {what} ist kein Text: einen Namen angeben"
    ),
    "{label} has no name: choose {named}": "{label} hat keinen Namen: {named} wählen",
    "{label} is impossible: use one of {choices} there": "{label} ist unmöglich: dort eines von {choices} verwenden",
    "{label} has a weight: a cut can only be hard": "{label} hat ein Gewicht: ein Schnitt geht nur hart",
    "row {number} is {row}: give it a 'where' and a 'what'": (
        "Zeile {number} ist {row}: ihr ein 'where' und ein 'what' geben"
    ),
    "{label} has {value}: use one of {choices}": "{label} hat {value}: eines von {choices} verwenden",
    "the {key} of {label} is {value}: give a number": "{key} von {label} ist {value}: eine Zahl angeben",
    "the {key} of {label} is {value}: give a finite number": (
        "{key} von {label} ist {value}: eine endliche Zahl angeben"
    ),
    "row {number} has the key {name}: use {choices}": "Zeile {number} hat den Schlüssel {name}: {choices} verwenden",
    "row {number}: {error}": "Zeile {number}: {error}",
    "{label}: {error}, or remove the row": "{label}: {error}, oder die Zeile entfernen",
    "the angle of features is {features}: give radians from 0 (none) to pi": (
        "der Winkel der Merkmale ist {features}: Bogenmaß von 0 (keine) bis pi angeben"
    ),
    "the mirror is {mirror}: use axes of X, Y and Z, such as X or XY": (
        "der Spiegel ist {mirror}: Achsen aus X, Y und Z verwenden, etwa X oder XY"
    ),
    "the {setting} is {value}: give a finite one": "{setting} ist {value}: eine endliche Zahl angeben",
    "the guidance smooth stands alone: leave it out of the blend": (
        "die Führung smooth steht allein: sie aus der Mischung lassen"
    ),
    "{label} gives {own} directions at a point, which cannot guide a {symmetry} field: {remedy}": (
        "{label} gibt {own} Richtungen an einem Punkt, was kein Feld der Symmetrie {symmetry} führen kann: {remedy}"
    ),
    "{name} is neither a vertex group nor an object: choose a vertex group ({groups}), a curve object, or boundary": (
        "{name} ist weder eine Punktgruppe noch ein Objekt: eine Punktgruppe ({groups}), ein Kurvenobjekt oder "
        "boundary wählen"
    ),
    "the guidance {kind} is unknown: use one of smooth, {choices}": (
        "die Führung {kind} gibt es nicht: smooth oder eine von {choices} verwenden"
    ),
    "the guidance {kind} takes no name: leave {name} out": "die Führung {kind} hat keinen Namen: {name} weglassen",
    "the guidance {kind} has no name: write {kind_2}: and {needed}": (
        "der Führung {kind} fehlt ihr Name: {kind_2}: und {needed} schreiben"
    ),
    "the axis {name} is unknown: use {needed}": "die Achse {name} gibt es nicht: {needed} verwenden",
    "the strength of {label} is {strength}: give a number from 0 on": (
        "die Stärke von {label} ist {strength}: eine Zahl ab 0 angeben"
    ),
    "the strength {strength} of {kind} is no number: write {kind_2}=1, or leave it out": (
        "die Stärke {strength} von {kind} ist keine Zahl: {kind_2}=1 schreiben oder sie weglassen"
    ),
    "the mesh {name} has no boundary: measure from a vertex group or a curve object": (
        "das Netz {name} hat keinen Rand: von einer Punktgruppe oder einem Kurvenobjekt aus messen"
    ),
    "there is no face {face} to pin: clear the pins, or pin again": (
        "es gibt keine Fläche {face} zum Festsetzen: nichts festsetzen oder neu festsetzen"
    ),
    "the pin {face}={turns} is none: write a face's number and its turns, such as 120=1": (
        "{face}={turns} legt nichts fest: die Nummer einer Fläche und ihre Drehungen schreiben, etwa 120=1"
    ),
    "{area} and {other} meet at {elements}: leave a part of the surface between them, across which the "
    "layers follow one another": (
        "{area} und {other} treffen sich an {elements}: einen Teil der Oberfläche dazwischen lassen, über den die"
        " Schichten aufeinander folgen"
    ),
    "{name} is neither a vertex group of {name_2} nor another mesh object: choose a group ({groups}), a "
    "mesh, or {boundary}": (
        "{name} ist weder eine Punktgruppe von {name_2} noch ein anderes Netzobjekt: eine Gruppe ({groups}), ein "
        "Netz oder {boundary} wählen"
    ),
    "the object {name} has no faces: choose a mesh whose surface layers can follow": (
        "das Objekt {name} hat keine Flächen: ein Netz wählen, dessen Oberfläche Schichten folgen können"
    ),
    "the object {name} cannot guide layers: {error}": "das Objekt {name} kann keine Schichten führen: {error}",
    "no layers of {name} are in memory ({kept_solids}): solve them first": (
        "keine Schichten von {name} sind im Speicher ({kept_solids}): zuerst lösen"
    ),
    "the mesh or the scale of {name} has changed since its layers were solved: solve again": (
        "das Netz oder die Skalierung von {name} hat sich geändert, seit die Schichten gelöst wurden: neu lösen"
    ),
    "{name} is in another mode and not active: make it the active object, or leave it": (
        "{name} ist in einem anderen Modus und nicht aktiv: es zum aktiven Objekt machen oder den Modus verlassen"
    ),
    "{path} begins with //, the folder of a .blend that is not saved: save it first": (
        "{path} beginnt mit //, dem Ordner einer .blend-Datei, die nicht gespeichert ist: zuerst speichern"
    ),
    "the layers of {name} were solved again meanwhile: run again": (
        "die Schichten von {name} wurden inzwischen neu gelöst: noch einmal ausführen"
    ),
    "the paths cover {share} of the layers, {part} of layer {number}: reduce the step, or take contours": (
        "die Bahnen bedecken {share} der Schichten, {part} der Schicht {number}: den Schritt verringern oder "
        "Konturen nehmen"
    ),
    "{share} of the paths lie {words}: {remedy}": "{share} der Bahnen liegen {words}: {remedy}",
    "{share} of the paths, {pieces}, lie {words}, the longest at ({place}) on layer {first}: {remedy}": (
        "{share} der Bahnen, {pieces}, liegen {words}, das längste bei ({place}) auf Schicht {first}: {remedy}"
    ),
    "the guidance {text} is incomplete: write {kind}:, {choices}": (
        "die Führung {text} ist unvollständig: {kind}:, {choices} schreiben"
    ),
    "the axis {names} is unknown: use X, Y or Z": "die Achse {names} gibt es nicht: X, Y oder Z verwenden",
    "the offset {offset} of the group {group} is none: write {held}:0 to {held_2}:0.99": (
        "der Versatz {offset} der Gruppe {group} ist keiner: {held}:0 bis {held_2}:0.99 schreiben"
    ),
    "the wish {wish} of the group {group} is unknown: use {choices}": (
        "den Wunsch {wish} der Gruppe {group} gibt es nicht: {choices} verwenden"
    ),
    "the group {named} lacks its name or its wish: write NAME=layer or NAME=constant": (
        "der Gruppe {named} fehlt ihr Name oder ihr Wunsch: NAME=layer oder NAME=constant schreiben"
    ),
    "the spacing {spacing} is not between the heights {limits}: give one that is, or none": (
        "der Abstand {spacing} liegt nicht zwischen den Höhen {limits}: einen angeben, der es tut, oder keinen"
    ),
    "the offset {offset} of the group {group} is no number: write {held}:0.5 for half a layer": (
        "der Versatz {offset} der Gruppe {group} ist keine Zahl: {held}:0.5 für eine halbe Schicht schreiben"
    ),
    "{name} is one-sided and encloses nothing: fill a closed surface with two sides": (
        "{name} ist einseitig und umschließt nichts: eine geschlossene Oberfläche mit zwei Seiten füllen"
    ),
    "{name} encloses no volume: give it thickness, with Solidify for instance": (
        "{name} umschließt kein Volumen: ihm eine Dicke geben, etwa durch Verdicken"
    ),
    "{elements} {verb} other faces of the mesh, where inside and outside cannot be told: join the parts "
    "with a Boolean union or a Remesh modifier, and apply it": (
        "{elements} {verb} andere Flächen des Netzes, wo sich innen und außen nicht unterscheiden lassen: die "
        "Teile mit einer Booleschen Vereinigung oder einem Remesh-Modifikator verbinden und ihn anwenden"
    ),
    "the solid is {solid}: give a TetMesh, or None to fill the surface": (
        "der Körper ist {solid}: ein TetMesh angeben, oder None, um die Oberfläche zu füllen"
    ),
    "the solid's boundary is up to {apart} from the surface of {name}: give the solid of this object": (
        "der Rand des Körpers ist bis zu {apart} von der Oberfläche von {name} entfernt: den Körper dieses "
        "Objekts angeben"
    ),
    "a resolution of {resolution} voxels shows no layer: give 2 or more": (
        "eine Auflösung von {resolution} Voxeln zeigt keine Schicht: mindestens 2 angeben"
    ),
}
