# SPDX-License-Identifier: GPL-3.0-or-later
"""What the interface says, in German. Words in braces are filled in."""

PANELS = {
    "Synch Fields": "Synch-Felder",
    "Direction fields, stripes and quads": "Richtungsfelder, Streifen und Vierecke",
    "Stripes, quads and direction fields on the active mesh": "Streifen, Vierecke und Richtungsfelder auf dem Netz",
    "Synch Samples": "Synch-Beispiele",
    "Shapes to try patterns on": "Formen, um Muster auszuprobieren",
    "Synch Fields Presets": "Vorgaben für Synch-Felder",
    "Settings of directions and patterns, kept under a name": "Unter einem Namen behaltene Einstellungen",
    "Bake": "Backen",
    "The pattern as images": "Das Muster als Bilder",
    "Constraints": "Bedingungen",
    "What is asked of the pattern along lines of the mesh": (
        "Was entlang von Linien des Netzes vom Muster verlangt wird"
    ),
    "Directions": "Richtungen",
    "What the stripes run along": "Woran die Streifen entlanglaufen",
    "Overlay": "Einblendung",
    "What is drawn over the active object": "Was über das aktive Objekt gezeichnet wird",
    "Pattern": "Muster",
    "How far stripes are from one another, and which faces show them": (
        "Abstand der Streifen, und welche Flächen sie zeigen"
    ),
    "Quads": "Vierecke",
    "What only quads have": "Was nur Vierecke haben",
    "Result": "Ergebnis",
    "What the last solve found": "Was die letzte Lösung gefunden hat",
    "Solver": "Löser",
    "How the fields are optimized": "Wie die Felder optimiert werden",
    "Vortices": "Wirbel",
    "Vortex filaments and tubes of a flow in space": "Wirbelfäden und -röhren einer Strömung im Raum",
    "What the last solve of the active object's vortices found": "Was die letzte Lösung der Wirbel gefunden hat",
}

OPERATORS = {
    "Stripes": "Streifen",
    "Cover the mesh with evenly spaced stripes along a direction field, branching where they must": (
        "Das Netz mit gleichmäßigen Streifen entlang eines Richtungsfelds bedecken, verzweigt, wo es sein muss"
    ),
    "Cover the mesh with a pattern of two crossing families of lines along a cross field": (
        "Das Netz mit zwei sich kreuzenden Scharen von Linien entlang eines Kreuzfelds bedecken"
    ),
    "Quad Mesh": "Vierecksnetz",
    "Make a new mesh of quads along the grid lines of a quad pattern, and hide the active one": (
        "Ein neues Netz aus Vierecken entlang der Gitterlinien bilden und das aktive ausblenden"
    ),
    "Mesh of These Quads": "Netz aus diesen Vierecken",
    "Make a new mesh of the quads that the object shows, without solving again, and hide the object": (
        "Ein neues Netz aus den gezeigten Vierecken bilden, ohne neu zu lösen, und das Objekt ausblenden"
    ),
    "Find a direction at every vertex and mark the points where it cannot be continuous": (
        "An jedem Punkt eine Richtung finden und markieren, wo sie nicht stetig sein kann"
    ),
    "Cancel": "Abbrechen",
    "Good Enough": "Gut genug",
    "Live": "Live",
    "Let stripes and quads follow their settings while these are dragged; click on Stripes or Quads for a full solve": (
        "Streifen und Vierecke folgen ihren Einstellungen, während man sie zieht; "
        "ein Klick auf Streifen oder Vierecke rechnet ganz"
    ),
    "Stop the solve and keep the pattern that it shows now": (
        "Die Berechnung beenden und das Muster behalten, das sie gerade zeigt"
    ),
    "Stop a solve that runs or waits; everything stays as it was": (
        "Einen laufenden oder wartenden Auftrag anhalten; alles bleibt, wie es war"
    ),
    "Place": "Platz",
    "Which job of the row, from 0 on; -1 for all of them": "Welcher Auftrag der Reihe, von 0 an; -1 für alle",
    "Memory Limit (MB)": "Speichergrenze (MB)",
    "Manual": "Handbuch",
    "Folder or web address of the manual, which Online Manual in the menu of a button opens": (
        "Ordner oder Netzadresse des Handbuchs, das Online-Handbuch im Menü eines Knopfs öffnet"
    ),
    "Memory that a solve may take before it is stopped; 0 stands for four fifths of the machine's": (
        "Speicher, den ein Auftrag belegen darf, bevor er angehalten wird; 0 steht für vier Fünftel der Maschine"
    ),
    "Subdivide for Spacing": "Für den Abstand unterteilen",
    "Copy Settings to Selected": "Einstellungen auf Auswahl übertragen",
    "Give the other selected objects the active one's settings, guides and constraints": "Den anderen ausgewählten "
    "Objekten die Einstellungen, Führungen und Bedingungen des aktiven geben",
    "Subdivide the mesh, so that it carries the spacing: smoothly where it looks smooth, else without changing its "
    "shape. UV maps, groups and attributes go over; a pattern on it has to be solved again": (
        "Das Netz unterteilen, damit es den Abstand trägt: glatt, wo es glatt aussieht, sonst ohne Änderung der Form. "
        "UV-Maps, Gruppen und Attribute bleiben; ein Muster darauf muss neu gelöst werden"
    ),
    "Level": "Stufe",
    "How often every edge is halved; where it is not set, as often as the spacing needs": (
        "Wie oft jede Kante halbiert wird; ohne Angabe so oft, wie der Abstand es braucht"
    ),
    "Variation": "Variante",
    "0 is the best one, the next are other good ones, high numbers are drawn at random": (
        "0 ist die beste, die nächsten sind andere gute, hohe Nummern sind zufällig gezogen"
    ),
    "Draw Variation": "Variante ziehen",
    "Show a configuration of defects that is drawn at random, from the last solve": (
        "Eine zufällig gezogene Anordnung der Defekte aus der letzten Lösung zeigen"
    ),
    "Show Loop": "Schleife zeigen",
    "Click near an edge to show the loop of quads through it; Enter keeps it in the overlay, Esc does not": (
        "Nahe einer Kante klicken zeigt die Schleife durch sie; Eingabe behält sie in der Einblendung, Esc nicht"
    ),
    "Place Defects": "Defekte setzen",
    "Click on the surface to put a dislocation there, drag to move it, click again for more; Enter ends, Esc undoes": (
        "Klicken setzt eine Versetzung, Ziehen bewegt sie, erneutes Klicken setzt weitere; Eingabe beendet, Esc "
        "verwirft"
    ),
    "Keep as Favourite": "Als Favorit behalten",
    "Keep the variation that is shown, as attributes of the mesh: it can be shown again at any time, also after "
    "the file was saved and opened": (
        "Die gezeigte Variante als Attribute des Netzes behalten: Sie kann jederzeit wieder gezeigt werden, auch "
        "nach dem Speichern und Öffnen der Datei"
    ),
    "What the favourite is called": "Wie der Favorit heißt",
    "Show Favourite": "Favorit zeigen",
    "Show this favourite again, without a solve": "Diesen Favoriten wieder zeigen, ohne zu lösen",
    "Remove Favourite": "Favorit entfernen",
    "Remove this favourite and its attributes; what is shown stays": (
        "Diesen Favoriten und seine Attribute entfernen; das Gezeigte bleibt"
    ),
    "Select Defect Faces": "Flächen mit Defekten auswählen",
    "Select the faces that hold a defect, in edit mode": "Die Flächen mit einem Defekt im Bearbeitungsmodus auswählen",
    "Select Places": "Stellen auswählen",
    "Select where the surface that was solved on is not the mesh as it is, in edit mode": (
        "Auswählen, wo die Fläche, auf der gelöst wurde, nicht das Netz ist, wie es ist, im Bearbeitungsmodus"
    ),
    "Which kind of place": "Welche Art von Stelle",
    "Frame Next Defect": "Nächsten Defekt zeigen",
    "Turn the view to the next defect and look at it from close by": (
        "Die Ansicht zum nächsten Defekt drehen und ihn von Nahem zeigen"
    ),
    "Copy Report": "Bericht kopieren",
    "Copy the full report of the last solve to the clipboard, as JSON": (
        "Den ganzen Bericht der letzten Lösung als JSON in die Zwischenablage kopieren"
    ),
    "Figure whose meaning the tooltip says": "Zahl, deren Bedeutung der Tooltip sagt",
    "Lines as Curves": "Linien als Kurven",
    "Make a curve object of the lines of the pattern: stripes by their middles or edges, quads by their grid": (
        "Ein Kurvenobjekt aus den Linien des Musters machen: Mitten oder Ränder der Streifen, Gitter der Vierecke"
    ),
    "Part of a period that is stripe and whose edges are drawn; 0 for the middles of stripes, 1 for those of "
    "gaps. Quads have grid lines: 0": (
        "Anteil des Streifens, dessen Ränder gezeichnet werden; 0 für die Mitten der Streifen, 1 für die der "
        "Lücken. Vierecke haben Gitterlinien: 0"
    ),
    "Distance": "Entfernung",
    "Between the points of a line, in spacings; 0 for where it crosses the mesh's edges": (
        "Zwischen den Punkten einer Linie, in Abständen; 0 für die Stellen, wo sie Kanten kreuzt"
    ),
    "How often points move to the middle of their neighbours, before they are put back on the surface": (
        "Wie oft Punkte zur Mitte ihrer Nachbarn rücken, bevor sie auf die Oberfläche zurückkehren"
    ),
    "Radius": "Radius",
    "Of tubes around the lines, in spacings; 0 for none": "Der Röhren um die Linien, in Abständen; 0 für keine",
    "Spline": "Spline",
    "What the lines are made of": "Woraus die Linien bestehen",
    "Poly": "Polygon",
    "Straight from point to point, with the tilt of the surface: ribbons lie on it": (
        "Gerade von Punkt zu Punkt, mit der Neigung der Oberfläche: Bänder liegen auf ihr"
    ),
    "Bezier": "Bézier",
    "Smooth through the points": "Glatt durch die Punkte",
    "NURBS": "NURBS",
    "Smooth along the points": "Glatt an den Punkten entlang",
    "Relief": "Relief",
    "Raise the surface by the pattern, with a modifier that subdivides it; its inputs can be changed at any time": (
        "Die Oberfläche durch das Muster heben, mit einem unterteilenden Modifikator; seine Werte sind jederzeit "
        "änderbar"
    ),
    "How high the pattern stands out of the surface, in spacings; below 0 it is cut in": (
        "Wie hoch das Muster aus der Oberfläche ragt, in Abständen; unter 0 ist es eingeschnitten"
    ),
    "Part of a period that is raised, or of the area of quads": "Gehobener Anteil einer Periode oder Vierecksfläche",
    "Profile": "Profil",
    "How often the mesh is subdivided; where it is not set, as often as its edges need": (
        "Wie oft das Netz unterteilt wird; ohne Angabe so oft, wie seine Kanten es brauchen"
    ),
    "Smooth": "Glatt",
    "Stripes: sine, square, triangle, rounded, thread. Quads: grid lines, checker, weave, dots": (
        "Streifen: Sinus, Rechteck, Dreieck, gerundet, Faden. Vierecke: Gitterlinien, Schachbrett, Gewebe, Punkte"
    ),
    "Round the surface while it is subdivided": "Die Oberfläche beim Unterteilen runden",
    "Bake what the pattern shows into images over a UV map, with Cycles, one map after the other; Esc cancels": (
        "Mit Cycles in Bilder über eine UV-Map backen, was das Muster zeigt, eines nach dem anderen; Esc bricht ab"
    ),
    "Add Synch Sample": "Synch-Beispiel hinzufügen",
    "Add a shape to try patterns on, with vertex groups and seams for constraints": (
        "Eine Form zum Ausprobieren hinzufügen, mit Punktgruppen und Nähten für Bedingungen"
    ),
    "Shape": "Form",
    "What is added": "Was hinzugefügt wird",
    "Suzanne": "Suzanne",
    "Blender's monkey as one smooth surface of even triangles": "Blenders Affe als eine glatte Fläche aus Dreiecken",
    "Pretzel": "Brezel",
    "A closed surface of quads with two holes, and seams that cut it in half": (
        "Eine geschlossene Fläche aus Vierecken mit zwei Löchern und Nähten, die sie halbieren"
    ),
    "Vase": "Vase",
    "A bent vase of quads, open at its rim, where a stripe is asked for": (
        "Eine gebogene Vase aus Vierecken, am Rand offen, wo ein Streifen verlangt ist"
    ),
    "Longest side of the object": "Längste Seite des Objekts",
    "Detail": "Feinheit",
    "Each step makes four times as many faces": "Jede Stufe macht viermal so viele Flächen",
    "Add Synch Fields Preset": "Vorgabe für Synch-Felder hinzufügen",
    "Keep the active object's settings under a name, or remove those of a name": (
        "Die Einstellungen des aktiven Objekts unter einem Namen behalten oder die eines Namens entfernen"
    ),
    "Import Direction Field": "Richtungsfeld importieren",
    "Read directions on triangles from a file, as the active object's directions, and follow them": (
        "Richtungen auf Dreiecken aus einer Datei als die des aktiven Objekts lesen und ihnen folgen"
    ),
    "Export Direction Field": "Richtungsfeld exportieren",
    "Write the active object's directions to a file, for each of its triangles": (
        "Die Richtungen des aktiven Objekts für jedes Dreieck in eine Datei schreiben"
    ),
}

SETTINGS = {
    "Symmetry": "Symmetrie",
    "What is the same at a point: one direction, a line or a cross": (
        "Was gleich ist: eine Richtung, Linie oder ein Kreuz"
    ),
    "Vector": "Vektor",
    "One direction at each point": "Eine Richtung an jedem Punkt",
    "Line": "Linie",
    "A direction and its opposite count as the same, as for stripes and hatching": (
        "Eine Richtung und ihre Gegenrichtung gelten als gleich, wie bei Streifen und Schraffuren"
    ),
    "Cross": "Kreuz",
    "Four directions at right angles, as for quads": "Vier Richtungen im rechten Winkel, wie bei Vierecken",
    "Guidance": "Führung",
    "What the directions follow": "Wem die Richtungen folgen",
    "smooth, or what the directions follow, such as curvature-max=2,axis:Z": (
        "smooth, oder wem die Richtungen folgen, etwa curvature-max=2,axis:Z"
    ),
    "Smoothest": "Am glattesten",
    "The field that turns least over the surface": "Das Feld, das sich über die Oberfläche am wenigsten dreht",
    "Blend": "Mischung",
    "Several guides, each with a strength": "Mehrere Führungen, jede mit einer Stärke",
    "Angle": "Winkel",
    "Turn the directions by this angle, counterclockwise seen from outside": (
        "Die Richtungen um diesen Winkel drehen, von außen gesehen gegen den Uhrzeigersinn"
    ),
    "Angle Map": "Winkelkarte",
    "Float attribute, radians added to the angle, or vertex group, which adds from 0 to the range": (
        "Gleitkommaattribut, Bogenmaß zusätzlich zum Winkel, oder Punktgruppe, die von 0 bis zur Spanne dreht"
    ),
    "Boundary": "Rand",
    "What happens at open edges": "Was an offenen Kanten geschieht",
    "Free": "Frei",
    "Nothing is asked of the boundary": "Vom Rand wird nichts verlangt",
    "Along": "Entlang",
    "Directions run along the boundary": "Richtungen laufen am Rand entlang",
    "Across": "Quer",
    "Directions meet the boundary at a right angle": "Richtungen treffen im rechten Winkel auf den Rand",
    "Line on It": "Linie darauf",
    "Directions run along the boundary and a stripe or grid line lies exactly on it": (
        "Richtungen laufen am Rand entlang, und ein Streifen oder eine Gitterlinie liegt genau darauf"
    ),
    "Vertex Group": "Punktgruppe",
    "Restrict the boundary to open edges with both ends in this group": (
        "Nur offene Kanten, deren beide Enden in dieser Gruppe sind"
    ),
    "Mirror": "Spiegel",
    "Make the pattern its own mirror image in these axes of the object, whose mesh has to be symmetric": (
        "Das Muster in diesen Achsen des Objekts, dessen Netz symmetrisch sein muss, zu seinem Spiegelbild machen"
    ),
    "Spacing": "Abstand",
    "Distance from one stripe to the next; the object's scale counts": (
        "Abstand von einem Streifen zum nächsten; die Skalierung des Objekts zählt"
    ),
    "Automatic Spacing": "Automatisch",
    "About forty stripes across the object, or as many as the mesh can carry": (
        "Etwa vierzig Streifen über das Objekt, oder so viele, wie das Netz trägt"
    ),
    "Spacing Map": "Abstandskarte",
    "Float attribute, a factor on the spacing, or vertex group, which takes it from 1 to the range": (
        "Gleitkommaattribut, ein Faktor auf den Abstand, oder Punktgruppe, die ihn von 1 bis zur Spanne führt"
    ),
    "Range": "Spanne",
    "Factor on the spacing where the vertex group's weight is 1": (
        "Faktor auf den Abstand beim Gewicht 1 der Punktgruppe"
    ),
    "Branching": "Verzweigung",
    "How much lines may branch to keep their distance: 100 for as much as even spacing needs, 0 for hardly any "
    "branches or none, where lines are nearer to and further from one another instead": (
        "Wie sehr sich Linien verzweigen dürfen, um ihren Abstand zu halten: 100 für so sehr, wie gleichmäßiger "
        "Abstand es braucht, 0 für kaum Verzweigungen oder keine, wofür die Abstände schwanken"
    ),
    "Mesh Branching": "Netzverzweigung",
    "How much the lines of quad meshes may branch to keep their distance: at 0 faces are quads all over and vary in "
    "size, at 100 their sizes are most even, but faces of five and six corners lie between": (
        "Wie sehr sich die Linien von Vierecksnetzen verzweigen dürfen, um ihren Abstand zu halten: bei 0 sind alle "
        "Flächen Vierecke verschiedener Größe, bei 100 sind sie am gleichmäßigsten, aber mit Fünf- und Sechsecken "
        "dazwischen"
    ),
    "Mesh Singularities": "Netzsingularitäten",
    "How many singular points the directions of quad meshes may have to stay smooth: below 100 those go that bend the "
    "least, and irregular vertices with them; at 0 there are the fewest that the shape allows, and quads vary in size "
    "instead": (
        "Wie viele singuläre Stellen die Richtungen von Vierecksnetzen haben dürfen, um glatt zu bleiben: unter 100 "
        "entfallen die, die am wenigsten biegen, und mit ihnen unregelmäßige Ecken; bei 0 sind es so wenige, wie die "
        "Form zulässt, wofür Vierecke verschieden groß werden"
    ),
    "Singularities": "Singularitäten",
    "How many singular points directions may have to stay smooth: 100 for as many as the shape's bumps call for, 0 for "
    "the fewest that it allows, where directions bend more and quads vary in size instead": (
        "Wie viele singuläre Stellen die Richtungen haben dürfen, um glatt zu bleiben: 100 für so viele, wie die "
        "Beulen der Form verlangen, 0 für so wenige, wie sie zulässt, wofür Richtungen sich mehr biegen und Vierecke "
        "verschieden groß werden"
    ),
    "Aspect": "Seitenverhältnis",
    "Spacing of quads along their second direction over that along the first, the one nearer to X; only where "
    "the two never change places around a disclination": (
        "Abstand der Vierecke in der zweiten Richtung geteilt durch den in der ersten, die näher an X liegt; nur, "
        "wo beide nie um eine Disklination die Plätze tauschen"
    ),
    "Smoothing": "Glättung",
    "How often the quad mesh's vertices move to where faces are nearer to squares, on the surface": (
        "Wie oft die Punkte des Vierecksnetzes auf der Oberfläche dorthin rücken, wo Flächen Quadraten näher sind"
    ),
    "Face Count": "Flächenzahl",
    "About how many faces the quad mesh is to have, whatever the spacing; 0 for as many as that gives": (
        "Wie viele Flächen das Vierecksnetz ungefähr haben soll, gleich welcher Abstand; 0 für so viele, wie dieser "
        "ergibt"
    ),
    "Feature Angle": "Kantenwinkel",
    "Boundaries and edges at which faces bend by more than this angle, or that are marked sharp, stay edges of the "
    "quad mesh; 0 for none of them": (
        "Ränder und Kanten, an denen Flächen sich um mehr als diesen Winkel biegen oder die als scharf markiert sind, "
        "bleiben Kanten des Vierecksnetzes; 0 für keine davon"
    ),
    "Straighten": "Begradigen",
    "Look for a quad mesh of shorter loops and fewer spirals among variations and with fewer singularities; takes two "
    "to three times as long": (
        "Unter Variationen und mit weniger Singularitäten ein Vierecksnetz kürzerer Schleifen und weniger Spiralen "
        "suchen; dauert zwei- bis dreimal so lang"
    ),
    "Method": "Verfahren",
    "How the field is optimized": "Wie das Feld optimiert wird",
    "Semidefinite": "Semidefinit",
    "Best results, with a bound on what could still be gained: proved, or estimated for large ones": (
        "Die besten Ergebnisse, und eine Schranke für das, was noch zu gewinnen wäre: bewiesen, bei Großem geschätzt"
    ),
    "Spectral": "Spektral",
    "Fast and rough: one eigenvector": "Schnell und grob: ein Eigenvektor",
    "Diffusion": "Diffusion",
    "Repeated smoothing and normalizing, without a useful bound": (
        "Wiederholtes Glätten und Normieren, ohne brauchbare Schranke"
    ),
    "Rounding": "Rundung",
    "How a field comes of the relaxation": "Wie aus der Relaxierung ein Feld wird",
    "Continuation": "Fortsetzung",
    "Search from many projections for the least energy": "Von vielen Projektionen aus die kleinste Energie suchen",
    "Polished": "Poliert",
    "The best of many random projections, and the local optimum below it": (
        "Die beste von vielen zufälligen Projektionen und das lokale Optimum darunter"
    ),
    "Randomized": "Zufällig",
    "The best of many random projections and the principal one, as it is": (
        "Die beste von vielen zufälligen Projektionen und der wichtigsten, so wie sie ist"
    ),
    "Singular Vector": "Singulärvektor",
    "The principal projection, as it is": "Die wichtigste Projektion, so wie sie ist",
    "Seed": "Startwert",
    "Another seed gives another result of about the same quality": (
        "Ein anderer gibt ein anderes, etwa gleich gutes Ergebnis"
    ),
    "Target Gap": "Ziellücke",
    "How closely the relaxation's optimum is bracketed, as a share of its energy": (
        "Wie eng das Optimum der Relaxierung eingegrenzt wird, als Anteil seiner Energie"
    ),
    "Assign to All Faces": "Allen Flächen zuweisen",
    "Show the pattern on all faces, also on an object with several materials": (
        "Das Muster auf allen Flächen zeigen, auch auf einem Objekt mit mehreren Materialien"
    ),
    "Guide": "Führung",
    "Guides": "Führungen",
    "The only guide": "Die einzige Führung",
    "The guides of a blend": "Die Führungen einer Mischung",
    "Favourites": "Favoriten",
    "Variations that are kept": "Behaltene Varianten",
    "Active Constraint": "Aktive Bedingung",
    "Row that the panel shows": "Zeile, die das Fenster zeigt",
    "Other configurations of defects from the last solve: 0 is the best one, the next are other good ones, high "
    "numbers are drawn at random": (
        "Andere Anordnungen der Defekte aus der letzten Lösung: 0 ist die beste, die nächsten sind andere gute, "
        "hohe Nummern sind zufällig gezogen"
    ),
    "What the panel shows of the last solve, as JSON": "Was von der letzten Lösung gezeigt wird, als JSON",
    "What the panel shows of it, as JSON": "Was davon gezeigt wird, als JSON",
    "What the slider said": "Was der Regler sagte",
    "Number": "Nummer",
    "The one in the names of its attributes": "Die in den Namen seiner Attribute",
}
