# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages of the core that artists meet."""

from __future__ import annotations

TEXTS = {
    "there is no library '{place}'; check the name, or index a folder into it first": "es gibt keine Bibliothek '{place}'; den Namen prüfen, oder erst einen Ordner hinein indizieren",
    "'{path}' cannot be reached: {reason}; choose another place": "'{path}' ist nicht erreichbar: {reason}; eine andere Stelle wählen",
    "'{path}' is a folder; a library is one file: name a file in it, such as 'shapes.sglib'": "'{path}' ist ein Ordner; eine Bibliothek ist eine Datei: eine Datei darin benennen, etwa 'shapes.sglib'",
    "'{path}' cannot be created: there is no folder '{folder}'; create it first": "'{path}' kann nicht angelegt werden: es gibt keinen Ordner '{folder}'; ihn erst anlegen",
    "'{name}' is empty; index a folder into it first": "'{name}' ist leer; erst einen Ordner hinein indizieren",
    "'{path}' is an SQLite database of another program, not a Shape Google library; choose another file": "'{path}' ist die SQLite-Datenbank eines anderen Programms, keine Bibliothek von Shape Google; eine andere Datei wählen",
    "'{path}' was made by a newer version of Shape Google (format {version}; this one reads formats {earlier} and {latest}); update Shape Google, or index your folders into a new library": "'{path}' wurde von einer neueren Version von Shape Google angelegt (Format {version}; diese liest die Formate {earlier} und {latest}); Shape Google aktualisieren, oder die Ordner in eine neue Bibliothek indizieren",
    "'{path}' was made by an older version of Shape Google (format {version}; this one reads formats {earlier} and {latest}); index your folders into a new library": "'{path}' wurde von einer älteren Version von Shape Google angelegt (Format {version}; diese liest die Formate {earlier} und {latest}); die Ordner in eine neue Bibliothek indizieren",
    "'{path}' is in use by another program that is writing to it (waited {timeout:g} s); try again when it has finished": "'{path}' wird von einem anderen Programm benutzt, das hineinschreibt ({timeout:g} s gewartet); erneut versuchen, wenn es fertig ist",
    "'{path}' or its folder is read-only: it can be searched, not changed; copy it to a place that can be written to add or remove shapes": "'{path}' oder sein Ordner ist schreibgeschützt: durchsuchbar, aber nicht änderbar; an eine beschreibbare Stelle kopieren, um Formen hinzuzufügen oder zu entfernen",
    "'{path}' cannot be read or written: the disk, its quota or the network drive refused; make room or copy the library to a local disk (everything added before is safe)": "'{path}' kann nicht gelesen oder geschrieben werden: Platte, Kontingent oder Netzlaufwerk verweigern es; Platz schaffen, oder die Bibliothek auf eine lokale Platte kopieren (alles zuvor Hinzugefügte ist sicher)",
    "'{path}' cannot be opened: you may not read the file, or not write into its folder; change the permissions, or copy it to a folder of yours": "'{path}' kann nicht geöffnet werden: die Datei darf nicht gelesen oder in ihren Ordner nicht geschrieben werden; die Rechte ändern, oder sie in einen eigenen Ordner kopieren",
    "'{path}' cannot grow: the disk is full; make room and run the same again (everything added before is safe)": "'{path}' kann nicht wachsen: die Platte ist voll; Platz schaffen und dasselbe erneut ausführen (alles zuvor Hinzugefügte ist sicher)",
    "'{path}' was interrupted while it was written and its place is read-only, so the interrupted part cannot be undone; copy it together with '{file}-journal' to a folder that can be written and open it there": "'{path}' wurde beim Schreiben unterbrochen, und die Stelle ist schreibgeschützt, sodass der unterbrochene Teil nicht rückgängig gemacht werden kann; zusammen mit '{file}-journal' in einen beschreibbaren Ordner kopieren und dort öffnen",
    "'{path}' cannot be created: its folder is read-only or not yours; choose another place": "'{path}' kann nicht angelegt werden: der Ordner ist schreibgeschützt oder gehört jemand anderem; eine andere Stelle wählen",
    "'{path}' is not a Shape Google library (not an SQLite database); choose another file": "'{path}' ist keine Bibliothek von Shape Google (keine SQLite-Datenbank); eine andere Datei wählen",
    "'{path}' cannot be used: there is not enough memory; close other programs and try again (everything added before is safe)": "'{path}' kann nicht benutzt werden: zu wenig Arbeitsspeicher; andere Programme schließen und noch einmal versuchen (alles vorher Hinzugefügte ist sicher)",
    "'{path}' cannot store a name, picture or bag of over a gigabyte; leave it out": "'{path}' kann keinen Namen, kein Bild und keine Wortverteilung von über einem Gigabyte speichern; weglassen",
    "'{library}' is damaged or was cut short ({detail}); restore it from a backup, or delete it and index your folders again": "'{library}' ist beschädigt oder wurde abgeschnitten ({detail}); aus einer Sicherung wiederherstellen, oder löschen und die Ordner erneut indizieren",
    "'{library}' has no shape {number}; it was removed or replaced: search again": "'{library}' hat keine Form {number}; sie wurde entfernt oder ersetzt: erneut suchen",
    "'{old}' and '{new}' are the same folder; name the one that it was and the new one": "'{old}' und '{new}' sind derselbe Ordner; den früheren und den neuen nennen",
    "none of the {count:,} files below '{old}' is in '{new}'; name the folder that has the same files and folders in it": "keine der {count:,} Dateien unter '{old}' ist in '{new}'; den Ordner nennen, der dieselben Dateien und Ordner enthält",
    "{name!r}: all points of its faces coincide; export the mesh again": "{name!r}: alle Punkte der Flächen fallen zusammen; die Masche erneut exportieren",
    "{name!r}: its faces have no area (all points lie on a line); export the mesh again": "{name!r}: die Flächen haben keinen Flächeninhalt (alle Punkte liegen auf einer Geraden); die Masche erneut exportieren",
    "{name!r}: all its points lie on a line; a shape needs points of a surface": "{name!r}: alle Punkte liegen auf einer Geraden; eine Form braucht Punkte einer Oberfläche",
    "the model {name!r} has taken the place of the one that described the meshes; find duplicates again": "das Modell {name!r} steht an der Stelle dessen, das die Maschen beschrieben hat; Duplikate erneut finden",
    "the process that computes has ended unexpectedly ({cause}); try again with a simpler shape": "der rechnende Prozess wurde unerwartet beendet ({cause}); mit einer einfacheren Form erneut versuchen",
    "Python cannot be started at {program!r} ({reason}); install Blender again, or use another build of it": "Python unter {program!r} kann nicht gestartet werden ({reason}); Blender erneut installieren, oder einen anderen Build verwenden",
    "the example {name!r} cannot be used: {reason}; remove it from the list of examples": "das Beispiel {name!r} kann nicht verwendet werden: {reason}; es aus der Liste der Beispiele entfernen",
}

OPERATORS: dict[str, str] = {}

COUNTED: dict[str, tuple[str, ...]] = {}
