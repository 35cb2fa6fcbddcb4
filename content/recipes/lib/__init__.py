"""The small library that the content recipes share: meshes, noise, PNG and glTF writers (standard library only)."""
