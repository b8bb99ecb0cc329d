# SPDX-License-Identifier: GPL-3.0-or-later
"""What the interface says where something is painted, drawn or pinned on the surface, and in the simple panel, in
German."""

DRAWING = {
    "Paint Map": "Karte malen",
    "Paint this map: its vertex group is made where there is none, and the mouse paints the brush's value": (
        "Diese Karte malen: wo es keine Punktgruppe gibt, wird sie angelegt, und die Maus malt den Wert des Pinsels"
    ),
    "Map": "Karte",
    "What is painted": "Was gemalt wird",
    "The factor on the spacing from place to place": "Der Faktor auf den Abstand von Ort zu Ort",
    "The angle that is added to the directions from place to place": (
        "Der Winkel, der von Ort zu Ort zu den Richtungen dazukommt"
    ),
    "Layer Spacing": "Schichtabstand",
    "The factor on the spacing of layers from place to place": "Der Faktor auf den Schichtabstand von Ort zu Ort",
    "Brush": "Pinsel",
    "Factor on the spacing that the brush paints, between 1 and the range": (
        "Faktor auf den Abstand, den der Pinsel malt, zwischen 1 und der Spanne"
    ),
    "Angle that the brush paints, between 0 and the range": "Winkel, den der Pinsel malt, zwischen 0 und der Spanne",
    "Paints {factor:.2f} × spacing": "Malt {factor:.2f} × Abstand",
    "Paints a turn by {angle:.0f}°": "Malt eine Drehung um {angle:.0f}°",
    "Done Painting": "Fertig gemalt",
    "Best": "Beste",
    "Show another near-optimal configuration of defects, from the last solve. On a thumbnail's button: how much more "
    "energy it has than the best, and the number of line ends": (
        "Eine andere fast optimale Anordnung von Defekten aus der letzten Lösung zeigen. Auf dem Knopf eines "
        "Bildchens: wie viel mehr Energie sie hat als die beste, und die Zahl der Linienenden"
    ),
    "Guide Strokes": "Führungsstriche",
    "Lines drawn on the surface that stripes follow": "Auf die Oberfläche gezeichnete Linien, denen Streifen folgen",
    "Draw on the active mesh what stripes follow; Ctrl erases, Shift smooths": (
        "Auf das aktive Netz zeichnen, wem Streifen folgen; Strg radiert, Umschalt glättet"
    ),
    "Draw Strokes": "Striche zeichnen",
    "Done Drawing": "Fertig gezeichnet",
    "Ctrl: erase   Shift: smooth": "Strg: radieren   Umschalt: glätten",
    "What the next stroke asks for": "Was der nächste Strich verlangt",
    "Stripes run along the stroke": "Streifen laufen am Strich entlang",
    "Stripes cross the stroke at a right angle": "Streifen kreuzen den Strich im rechten Winkel",
    "Stripe Here": "Streifen hier",
    "A stripe lies on the stroke": "Auf dem Strich liegt ein Streifen",
    "Draw the pattern towards the next stroke, not hold it exactly": (
        "Das Muster zum nächsten Strich hinziehen, nicht genau einhalten"
    ),
    "How strongly a soft stroke draws: at 1 about as strongly as the rest of the surface resists": (
        "Wie stark ein weicher Strich zieht: bei 1 etwa so stark, wie der Rest der Oberfläche widersteht"
    ),
    "Draw Stroke": "Strich zeichnen",
    "Draw on the surface what stripes follow": "Auf die Oberfläche zeichnen, wem Streifen folgen",
    "Erase Strokes": "Striche radieren",
    "Remove the strokes that the pointer passes over": "Die Striche entfernen, über die der Zeiger fährt",
    "Smooth Strokes": "Striche glätten",
    "Smooth strokes where the pointer passes over them": "Striche glätten, wo der Zeiger über sie fährt",
    "{count} strokes on {name}": "{count} Striche auf {name}",
    "{count} strokes smoothed": "{count} Striche geglättet",
    "leave the present mode: strokes are drawn in object mode": (
        "den Modus verlassen: Striche werden im Objektmodus gezeichnet"
    ),
    "Height of the pattern across a stripe or a quad, which light shows": (
        "Höhe des Musters quer durch einen Streifen oder ein Viereck, die Licht zeigt"
    ),
    "Sine": "Sinus",
    "Square": "Rechteck",
    "Triangle": "Dreieck",
    "Rounded": "Gerundet",
    "Thread": "Faden",
    "Grid lines": "Gitterlinien",
    "Checker": "Schachbrett",
    "Weave": "Gewebe",
    "Dots": "Punkte",
    "Softness": "Weich",
    "Mesh Changed: Solve Again": "Netz geändert: neu lösen",
    "Show Defects": "Defekte zeigen",
    "{length} apart on {count:,} faces": "Abstand {length}, {count:,} Flächen",
    "The distance from one line to the next that was asked for, as it was used, and how many faces the mesh has": (
        "Der verlangte Abstand von einer Linie zur nächsten, wie er verwendet wurde, und die Zahl der Flächen"
    ),
    "No UV map: Smart UV Project makes one": "Keine UV-Map: Smart UV Project macht eine",
    "{more:+.1%} energy, against the best": "{more:+.1%} Energie gegenüber der besten",
    "{name} is hidden": "{name} ist ausgeblendet",
    "Measured: {shape}": "Gemessen: {shape}",
    "Carry Through Modifiers": "Durch Modifikatoren tragen",
    "Carry the pattern through the modifiers before, such as Subdivision, Mirror and Solidify: directions, phases and "
    "pattern are made anew at the vertices that they leave": (
        "Das Muster durch die Modifikatoren davor tragen, etwa Unterteilung, Spiegeln und Wandstärke: Richtungen, "
        "Phasen und Muster werden an den Punkten neu gemacht, die sie hinterlassen"
    ),
    "About {length} apart": "Abstand etwa {length}",
    "Pin": "Festsetzen",
    "pin": "Festpunkt",
    "pins": "Festpunkte",
    "{pins}: about {more:+.0%} bending": "{pins}: etwa {more:+.0%} Biegung",
    "Pin a Swirl Point": "Wirbelpunkt festsetzen",
    "Click on the surface to choose around which face directions turn, and how often; drag to move it, Enter ends, Esc "
    "undoes. Solve again, or let Live follow": (
        "Auf die Oberfläche klicken, um zu wählen, um welche Fläche sich Richtungen drehen, und wie oft; Ziehen "
        "bewegt, Eingabe beendet, Esc macht rückgängig. Neu lösen, oder Live folgen lassen"
    ),
    "Turns": "Drehungen",
    "How often directions turn: halves for lines, quarters for crosses, 0 for a face without a swirl point": (
        "Wie oft sich Richtungen drehen: halbe für Linien, viertel für Kreuze, 0 für eine Fläche ohne Wirbelpunkt"
    ),
    "Click: pin a face   Drag: move it   Enter: done   Esc: as before": (
        "Klicken: Fläche festsetzen   Ziehen: bewegen   Eingabe: fertig   Esc: wie vorher"
    ),
    "Clear Pins": "Nichts festsetzen",
    "Let directions turn where they want": "Richtungen sich drehen lassen, wo sie wollen",
    "Pins": "Festgesetzt",
    "Faces around which directions turn as often as is said here, in the smallest turns that there are: halves for "
    "lines, quarters for crosses": (
        "Flächen, um die sich Richtungen so oft drehen, wie hier steht, in den kleinsten Drehungen, die es gibt: "
        "halben für Linien, vierteln für Kreuze"
    ),
    "Panel": "Tafel",
    "What the sidebar shows": "Was die Seitenleiste zeigt",
    "Simple": "Einfach",
    "Size, direction, branching, look and one button": "Größe, Richtung, Verzweigung, Aussehen und ein Knopf",
    "Advanced": "Erweitert",
    "All settings, constraints, layers, vortices, bake and animation": (
        "Alle Einstellungen, Bedingungen, Schichten, Wirbel, Backen und Animation"
    ),
    "Make": "Machen",
    "What the button makes": "Was der Knopf macht",
    "Even stripes over the surface": "Gleichmäßige Streifen über die Oberfläche",
    "A grid of squares over the surface": "Ein Gitter von Quadraten über die Oberfläche",
    "A new mesh of quads, and the object is hidden": "Ein neues Netz aus Vierecken, und das Objekt wird ausgeblendet",
    "What lines follow": "Wem Linien folgen",
    "Lines that turn as little as the shape allows (the smoothest direction field)": (
        "Linien, die sich so wenig drehen, wie die Form es erlaubt (das glatteste Richtungsfeld)"
    ),
    "Along Curvature": "Mit der Krümmung",
    "Lines along ridges, where the surface bends least (principal directions)": (
        "Linien an Graten entlang, wo sich die Oberfläche am wenigsten biegt (Hauptkrümmungsrichtungen)"
    ),
    "Around an Axis": "Um eine Achse",
    "Rings around an axis of the object": "Ringe um eine Achse des Objekts",
    "Strokes": "Striche",
    "Lines that you draw on the surface": "Linien, die Sie auf die Oberfläche zeichnen",
    "As in Advanced": "Wie erweitert",
    "What the settings under Advanced ask for": "Was die Einstellungen unter Erweitert verlangen",
    "Whether lines follow strokes that are drawn": "Ob Linien gezeichneten Strichen folgen",
    "Angle Range": "Winkelspanne",
    "Angle that is added where the vertex group's weight is 1": (
        "Winkel, der beim Gewicht 1 der Punktgruppe dazukommt"
    ),
}
