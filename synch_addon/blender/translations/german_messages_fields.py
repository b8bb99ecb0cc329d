# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors and warnings in German: of fields, their extraction and the solver, and of settings that every room has."""

FIELDS = {
    "no memory for a factorization of {count} unknowns: solve a coarser mesh, or its parts": (
        "kein Speicher für eine Zerlegung mit {count} Unbekannten: ein gröberes Netz lösen oder seine Teile"
    ),
    "{what} {count} times, and more than {most} are not drawn: make the spacing {factor} times as large": (
        "{what} {count}-mal, und mehr als {most} werden nicht gezeichnet: den Abstand {factor}-mal so groß machen"
    ),
    "the width is {width}: give a part of a period from 0 (middles) to 1 (middles of gaps)": (
        "die Breite ist {width}: einen Teil einer Periode von 0 (Mitten) bis 1 (Mitten der Lücken) angeben"
    ),
    "quads are drawn by their grid lines, which have no width: set the width to 0": (
        "Vierecke zeichnet man durch ihre Gitterlinien, die keine Breite haben: die Breite auf 0 setzen"
    ),
    "no grid lines cross on the mesh: reduce the spacing": (
        "auf dem Netz kreuzen sich keine Gitterlinien: den Abstand verringern"
    ),
    "the quads are too large for the mesh, some would meet themselves: reduce the spacing": (
        "die Vierecke sind zu groß für das Netz, manche träfen sich selbst: den Abstand verringern"
    ),
    "the quads are too large for the mesh, a handle of it would be lost: reduce the spacing": (
        "die Vierecke sind zu groß für das Netz, ein Henkel ginge verloren: den Abstand verringern"
    ),
    "the step between paths is {step}: give a positive number": (
        "der Schritt zwischen Bahnen ist {step}: eine positive Zahl angeben"
    ),
    "paths {step} apart have {points} points, and {most_points} is the most: give a step of {value} or more": (
        "Bahnen im Abstand {step} haben {points} Punkte, und mehr als {most_points} dürfen es nicht sein: einen "
        "Schritt von mindestens {value} angeben"
    ),
    "the core radius is {core}: give a positive length": "der Radius des Kerns ist {core}: eine positive Länge angeben",
    "a filament has a single point: give it two at least": (
        "ein Wirbelfaden hat nur einen Punkt: mindestens zwei angeben"
    ),
    "{what} is {share}: give a share from 0 to 1": "{what} ist {share}: einen Anteil von 0 bis 1 angeben",
    "the least change that takes out the holonomy was not found: remove the mesh's flattest triangles": (
        "die kleinste Änderung, die die Holonomie nimmt, wurde nicht gefunden: die flachsten Dreiecke des Netzes "
        "entfernen"
    ),
    "the velocity at node {tuple} ({bad} in all) is not a number: fill or crop the grid": (
        "die Geschwindigkeit am Knoten {tuple} (insgesamt {bad}) ist keine Zahl: das Gitter füllen oder beschneiden"
    ),
    "the velocity at {elements} is not a number: give finite vectors": (
        "die Geschwindigkeit an {elements} ist keine Zahl: endliche Vektoren angeben"
    ),
    "the flow has no vorticity: there are no vortices to show": (
        "die Strömung hat keine Wirbelstärke: es gibt keine Wirbel zu zeigen"
    ),
    "the circulation of a filament is {quantum}: give a positive one": (
        "die Zirkulation eines Fadens ist {quantum}: eine positive angeben"
    ),
    "filaments of the circulation {quantum} are too many for the grid, {value} for each of its faces: give"
    " a circulation from {value_2} on, or a finer grid": (
        "Fäden der Zirkulation {quantum} sind zu viele für das Gitter, {value} auf jede Fläche: eine Zirkulation "
        "ab {value_2} oder ein feineres Gitter angeben"
    ),
    "{row} and {other} fix {vertices} to different phases: {remedy}": (
        "{row} und {other} legen {vertices} auf verschiedene Phasen fest: {remedy}"
    ),
    "{row} cannot keep its phase constant at {vertices}: another row comes back to it with another phase, "
    "remove one of them": (
        "{row} kann die Phase an {vertices} nicht konstant halten: eine andere Zeile kommt mit einer anderen "
        "Phase dorthin zurück, eine von beiden entfernen"
    ),
    "{row} joins {vertices}, for which different values are asked: make them agree, or ask for one only": (
        "{row} verbindet {vertices}, für die verschiedene Werte verlangt sind: sie angleichen oder nur einen verlangen"
    ),
    "the mesh has no boundary: set the boundary to free": "das Netz hat keinen Rand: den Rand auf frei setzen",
    "a stroke has a single point: give it two at least": "ein Strich hat nur einen Punkt: mindestens zwei angeben",
    "the vertex group holds no boundary edge: add both ends of at least one to it": (
        "die Punktgruppe enthält keine Randkante: beide Enden mindestens einer Randkante hinzufügen"
    ),
    "{row} and {other} ask for different directions at {vertices}: remove one of them there": (
        "{row} und {other} verlangen an {vertices} verschiedene Richtungen: dort eine von beiden entfernen"
    ),
    "{row} asks for {kind}: use one of {choices}": "{row} verlangt {kind}: eines von {choices} verwenden",
    "the value of {row} is {value}: give a finite number": "der Wert von {row} ist {value}: eine endliche Zahl angeben",
    "the weight of {row} is {weight}: give a number from 0 to {largest_weight}, or none to hold it exactly": (
        "das Gewicht von {row} ist {weight}: eine Zahl von 0 bis {largest_weight} angeben, oder keine, um es "
        "genau einzuhalten"
    ),
    "{row} is soft: a phase that is constant along a line can only be hard": (
        "{row} ist weich: eine Phase, die entlang einer Linie konstant ist, geht nur hart"
    ),
    "symmetry {symmetry} is unknown: use 1 (vector), 2 (line) or 4 (cross)": (
        "die Symmetrie {symmetry} gibt es nicht: 1 (Vektor), 2 (Linie) oder 4 (Kreuz) verwenden"
    ),
    "pins hold one side of a mirror alone: remove the pins, or the mirror": (
        "festgesetzte Punkte halten nur eine Seite eines Spiegels: sie oder den Spiegel entfernen"
    ),
    "the guidance vector of vertex {vertex} ({bad} in all) is zero or points straight out of the surface: "
    "give it a tangential direction": (
        "der Führungsvektor des Punkts {vertex} (insgesamt {bad}) ist null oder zeigt senkrecht aus der "
        "Oberfläche: ihm eine tangentiale Richtung geben"
    ),
    "there is no triangle {triangle}: the mesh has {triangle_count}, from 0 on": (
        "es gibt kein Dreieck {triangle}: das Netz hat {triangle_count}, gezählt ab 0"
    ),
    "the index {index} of a pin is none: use a multiple of {value}": (
        "der Index {index} eines festgesetzten Punkts ist keiner: ein Vielfaches von {value} verwenden"
    ),
    "{area} is smaller than the solid's triangles: reduce the size, or mark a larger area": (
        "{area} ist kleiner als die Dreiecke des Körpers: die Größe verringern oder einen größeren Bereich markieren"
    ),
    "a field is carried between meshes of different triangles: solve it afresh": (
        "ein Feld wird zwischen Netzen aus verschiedenen Dreiecken übertragen: neu lösen"
    ),
    "two different spacings need a cross field whose two directions never change places, but here they do,"
    " around disclinations on the piece of vertex {vertex}: use the same for both (an aspect of 1)": (
        "zwei verschiedene Abstände brauchen ein Kreuzfeld, dessen Richtungen nie die Plätze tauschen, hier aber "
        "tun sie es, um Disklinationen auf dem Stück des Punkts {vertex}: für beide denselben verwenden "
        "(Seitenverhältnis 1)"
    ),
    "no vertex with a face is in the {area}: add at least one": (
        "kein Punkt mit einer Fläche ist in {area}: mindestens einen hinzufügen"
    ),
    "the guiding values are the same all over: give them a slope, or leave this guide out": (
        "die führenden Werte sind überall gleich: ihnen ein Gefälle geben oder diese Führung weglassen"
    ),
    "the axis {axis} has no direction: give three finite numbers, not all zero": (
        "die Achse {axis} hat keine Richtung: drei endliche Zahlen angeben, nicht alle null"
    ),
    "the axis {axis} points straight out of the surface everywhere: tilt it": (
        "die Achse {axis} zeigt überall senkrecht aus der Oberfläche: sie kippen"
    ),
    "every guidance vector is zero or points straight out of the surface: give at least one vertex a "
    "tangential direction": (
        "jeder Führungsvektor ist null oder zeigt senkrecht aus der Oberfläche: mindestens einem Punkt eine "
        "tangentiale Richtung geben"
    ),
    "every vertex is at distance 0: leave at least one out of the group of sources": (
        "jeder Punkt hat den Abstand 0: mindestens einen aus der Gruppe der Quellen lassen"
    ),
    "there are no guides to blend: give at least one": "es gibt keine Führungen zu mischen: mindestens eine angeben",
    "the shares {shares} do not fit {count} guides: give each a finite number, 0 or more": (
        "die Anteile {shares} passen nicht zu {count} Führungen: jeder eine endliche Zahl ab 0 geben"
    ),
    "the guides belong to meshes of different size: make them all on the same one": (
        "die Führungen gehören zu Netzen verschiedener Größe: alle auf demselben machen"
    ),
    "the {what} of {where} is not a finite number: set it, or remove the attribute": (
        "{what} von {where} ist keine endliche Zahl: sie setzen oder das Attribut entfernen"
    ),
    "{elements} are in both groups of the harmonic function: take them out of one": (
        "{elements} sind in beiden Gruppen der harmonischen Funktion: aus einer herausnehmen"
    ),
    "Poisson's equation on the solid's {count} vertices did not converge: remove its flattest tetrahedra, "
    "or make it anew at another resolution": (
        "die Poisson-Gleichung auf den {count} Punkten des Körpers konvergierte nicht: seine flachsten Tetraeder "
        "entfernen oder ihn mit anderer Auflösung neu machen"
    ),
    "the guiding values are the same all over the solid: give them a slope": (
        "die führenden Werte sind im ganzen Körper gleich: ihnen ein Gefälle geben"
    ),
    "the guidance vector of {elements} is not finite: set its numbers": (
        "der Führungsvektor von {elements} ist nicht endlich: seine Zahlen setzen"
    ),
    "every guidance vector of the solid is zero: give at least one vertex a direction": (
        "jeder Führungsvektor des Körpers ist null: mindestens einem Punkt eine Richtung geben"
    ),
    "the guiding curves have no length: draw at least one inside the solid": (
        "die führenden Kurven haben keine Länge: mindestens eine im Körper zeichnen"
    ),
    "{size} spacings are given for {vertex_count} vertices: give each one, or one": (
        "{size} Abstände sind für {vertex_count} Punkte gegeben: jedem einen geben, oder einen für alle"
    ),
    "{area} has {size} values and the solid {vertex_count} vertices: give each a truth value": (
        "{area} hat {size} Werte und der Körper {vertex_count} Punkte: jedem einen Wahrheitswert geben"
    ),
    "no layer is between {limits} high: give a smallest height from 0 on, and a largest one above it": (
        "keine Schicht ist zwischen {limits} hoch: eine kleinste Höhe ab 0 und eine größere größte Höhe angeben"
    ),
    "{row} and what is fixed at {vertices} contradict each other: change one of them": (
        "{row} und was an {vertices} festgelegt ist widersprechen sich: eines von beiden ändern"
    ),
    "the spacing {spacing} is larger than the object ({extent}): no {what} would fit, reduce it": (
        "der Abstand {spacing} ist größer als das Objekt ({extent}): {what} hätte keinen Platz, verringern Sie ihn"
    ),
    "the spacing is {spacing}: give a positive length": "der Abstand ist {spacing}: eine positive Länge angeben",
    "{count} defects are too many: the solved field leaves room for {most_defects} at a time": (
        "{count} Defekte sind zu viele: das gelöste Feld lässt für {most_defects} zugleich Platz"
    ),
    "no field near the solution has a defect at {elements}: choose others nearby": (
        "kein Feld nahe der Lösung hat einen Defekt an {elements}: andere in der Nähe wählen"
    ),
    "the vertices are {vertices}: give the numbers of one or more": (
        "die Punkte sind {vertices}: die Nummern von einem oder mehreren angeben"
    ),
    "there is no vertex {outside}: the mesh has {count}, from 0 on": (
        "es gibt keinen Punkt {outside}: das Netz hat {count}, gezählt ab 0"
    ),
    "quads need a cross field: set the symmetry to cross": (
        "Vierecke brauchen ein Kreuzfeld: die Symmetrie auf Kreuz setzen"
    ),
    "stripes need a vector or line field: set the symmetry to vector or line": (
        "Streifen brauchen ein Vektor- oder Linienfeld: die Symmetrie auf Vektor oder Linie setzen"
    ),
    "the {label} is {value}: give {asked}": "{label} ist {value}: {asked} angeben",
    "{what} is {path}: give a text": "{what} ist {path}: einen Text angeben",
    "{what} is {value}, which has a null character: no file can be called that": (
        "{what} ist {value} und hat ein Nullzeichen: keine Datei kann so heißen"
    ),
    "the {label} {value} is unknown: use one of {choices}": (
        "{label} {value} gibt es nicht: eines von {choices} verwenden"
    ),
    "the setting {name} is unknown: use one of {choices}": (
        "die Einstellung {name} gibt es nicht: eine von {choices} verwenden"
    ),
    "the {label} is {value}: give a smaller number": "{label} ist {value}: eine kleinere Zahl angeben",
    "{what} is {text}, which is no text: write it as UTF-8": (
        "{what} ist {text}, was kein Text ist: als UTF-8 schreiben"
    ),
    "the {label} is {value}: give a whole number from 0 {upwards}": (
        "{label} ist {value}: eine ganze Zahl ab 0 angeben ({upwards})"
    ),
    "the {label} is {value}: give a positive number": "{label} ist {value}: eine positive Zahl angeben",
    "{what} takes about {needs} of {memory} and {has} are left: use a coarser mesh, or {remedy}": (
        "{what} braucht etwa {needs}, und von {memory} sind {has} übrig: ein gröberes Netz verwenden, oder {remedy}"
    ),
    "there is no lifted field: solve with the method sdp": "es gibt kein erweitertes Feld: mit dem Verfahren sdp lösen",
    "{count} defects are too many: the lifted field has rank {rank}, which allows {most_defects} at a time": (
        "{count} Defekte sind zu viele: das erweiterte Feld hat den Rang {rank}, der {most_defects} zugleich erlaubt"
    ),
    "the phase of node {nodes} is fixed: a defect can only be where it is free": (
        "die Phase des Knotens {nodes} ist festgelegt: ein Defekt kann nur sein, wo sie frei ist"
    ),
    "the {what} is {text}: give a text such as {form}": "die Angabe {what} ist {text}: einen Text wie {form} angeben",
    'the {what} {text} cannot be read: write {form}, and names with , : = or " in double quotes': (
        'die Angabe {what} {text} lässt sich nicht lesen: {form} schreiben, und Namen mit , : = oder " in '
        "doppelten Anführungszeichen"
    ),
    "there is not enough memory for this: use a coarser mesh, or close other programs": (
        "dafür ist nicht genug Speicher da: ein gröberes Netz verwenden oder andere Programme schließen"
    ),
}
