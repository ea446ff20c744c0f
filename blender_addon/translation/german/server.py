# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts of libraries that a server offers, and of the folders of their roots."""

from __future__ import annotations

TEXTS = {
    "The folder of '{path}' is not known on this computer; choose that of its root, the first part of this path, under Folders of Roots in the panel Library": "Der Ordner von '{path}' ist auf diesem Rechner nicht bekannt; den seiner Wurzel, des ersten Teils dieses Pfads, unter Ordner der Wurzeln im Panel Bibliothek wählen",
    "'{path}' does not exist on this computer; check the folder of its root under Folders of Roots in the panel Library": "'{path}' gibt es auf diesem Rechner nicht; den Ordner seiner Wurzel unter Ordner der Wurzeln im Panel Bibliothek prüfen",
    "This library is on a server: shapes are added, moved and removed there, with the command shapegoogle": "Diese Bibliothek ist auf einem Server: Formen werden dort hinzugefügt, verschoben und entfernt, mit dem Befehl shapegoogle",
    "Turn on Search on a Server in the add-on's preferences; its tooltip says what is sent": "Suche auf einem Server in den Einstellungen des Add-ons einschalten; der Tooltip sagt, was gesendet wird",
    "Blender is offline: turn on Allow Online Access in its preferences, under System": "Blender ist offline: Online-Zugriff (Allow Online Access) in den Einstellungen unter System einschalten",
    "Blender is offline; Allow Online Access is in its preferences, under System": "Blender ist offline; Online-Zugriff (Allow Online Access) steht in den Einstellungen unter System",
    "Root": "Wurzel",
    "Where it is; empty if that is not known": "Wo sie ist; leer, wenn das nicht bekannt ist",
    "What is wrong with the connection to a server; empty for nothing": "Was an der Verbindung zu einem Server nicht stimmt; leer für nichts",
    "Connect to Server": "Mit Server verbinden",
    "Search a library that a server offers, which shapegoogle serve runs there, or a database": "Eine Bibliothek durchsuchen, die ein Server anbietet, auf dem shapegoogle serve läuft, oder eine Datenbank",
    "Choose Folder of Root": "Ordner der Wurzel wählen",
    "Say which folder of this computer has the files of this root of the library, so that matches can be appended, linked and opened": "Angeben, welcher Ordner dieses Rechners die Dateien dieser Wurzel der Bibliothek hat, damit Treffer angefügt, verknüpft und geöffnet werden können",
    "Add Root": "Wurzel hinzufügen",
    "Add a root of a library, to say which folder it is on this computer": "Eine Wurzel einer Bibliothek hinzufügen, um anzugeben, welcher Ordner sie auf diesem Rechner ist",
    "Remove Root": "Wurzel entfernen",
    "Remove the root from the list; the library and the folder stay as they are": "Die Wurzel aus der Liste entfernen; Bibliothek und Ordner bleiben, wie sie sind",
    "Address": "Adresse",
    "Such as https://shapes.example, or postgresql://artist@server/shapes of a database": "Etwa https://shapes.example, oder postgresql://kuenstler@server/formen einer Datenbank",
    "https://shapes.example": "https://shapes.example",
    "Token": "Token",
    "Password": "Passwort",
    "From whoever runs the server, or the password of the database; leave it empty if you have one there already": "Von denen, die den Server betreiben, oder das Passwort der Datenbank; leer lassen, wenn dort schon eines vorhanden ist",
    "Search on a Server": "Suche auf einem Server",
    "Folders of Roots": "Ordner der Wurzeln",
    "Open Preferences": "Einstellungen öffnen",
    "Shapes are added on the server; here you search and decide": "Formen werden auf dem Server hinzugefügt; hier wird gesucht und entschieden",
    "Choose Folder": "Ordner wählen",
    "File that stores the signatures of all shapes, created when you first index into it; or the address of a server or a database, such as https://shapes.example": "Datei mit den Signaturen aller Formen, beim ersten Indizieren angelegt; oder die Adresse eines Servers oder einer Datenbank, etwa https://shapes.example",
    "Find Similar and Suggest Tags send the signature of the selected shapes to the server in Library: numbers and 600 points of the surface, not the mesh. Filters, examples and decisions are sent too. Nothing is sent while this is off, or while Blender is offline": "Ähnliche finden und Schlagwörter vorschlagen senden die Signatur der ausgewählten Formen an den Server unter Bibliothek: Zahlen und 600 Punkte der Oberfläche, nicht die Masche. Auch Filter, Beispiele und Entscheidungen werden gesendet. Nichts wird gesendet, solange dies aus oder Blender offline ist",
    "Name of the root in the library": "Name der Wurzel in der Bibliothek",
    "Folder that the root is on this computer": "Ordner, der die Wurzel auf diesem Rechner ist",
    "Of the server in Library, from whoever runs it; of a database the password. It is kept in a file of the add-on that only you may read, not in Blender's preferences": "Des Servers unter Bibliothek, von denen, die ihn betreiben; bei einer Datenbank das Passwort. Es wird in einer Datei des Add-ons verwahrt, die niemand sonst lesen darf, nicht in Blenders Einstellungen",
    "Certificate": "Zertifikat",
    "File with the certificate of the server, if no authority has signed it": "Datei mit dem Zertifikat des Servers, wenn keine Zertifizierungsstelle es signiert hat",
    "Server": "Server",
}

OPERATORS: dict[str, str] = {}

COUNTED: dict[str, tuple[str, ...]] = {}
