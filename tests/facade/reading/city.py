"""City models with walls."""

import numpy as np

ARCH = np.array([[2, 1], [4, 1], [4, 4], [3, 5], [2, 4]], dtype=np.float64)
DOOR = np.array([[6, 0], [7, 0], [7, 2.5], [6, 2.5]], dtype=np.float64)
WALL = np.array([[0, 0], [9, 0], [9, 6], [0, 6]], dtype=np.float64)
NAMESPACES = {
    2: ("http://www.opengis.net/citygml/2.0", "http://www.opengis.net/gml", "opening", "Window", "Door"),
    3: ("http://www.opengis.net/citygml/3.0", "http://www.opengis.net/gml/3.2", "fillingSurface", "WindowSurface",
        "DoorSurface"),
}  # fmt: skip


class City:
    """Text of a file with walls in given planes."""

    def __init__(self, version: int = 2, angle: float = 0.3, origin: tuple[float, ...] = (678e3, 5403e3, 416.0)):
        self.core, self.gml, self.opening, self.window, self.door = NAMESPACES[version]
        self.right = np.array([np.cos(angle), np.sin(angle), 0.0])
        self.out = np.array([np.sin(angle), -np.cos(angle), 0.0])
        self.origin = np.array(origin)
        self.parts: list[str] = []

    def ring(self, corners: np.ndarray, depth: float = 0.0) -> str:
        points = self.origin + corners[:, :1] * self.right + corners[:, 1:] * [[0, 0, 1]] + depth * self.out
        closed = np.vstack([points, points[:1]])
        return f"<g:LinearRing><g:posList>{' '.join(map(repr, closed.ravel().tolist()))}</g:posList></g:LinearRing>"

    def polygon(self, corners: np.ndarray, *holes: np.ndarray, depth: float = 0.0, name: str = "") -> str:
        inner = "".join(f"<g:interior>{self.ring(hole[::-1], depth)}</g:interior>" for hole in holes)
        identity = f' g:id="{name}"' if name else ""
        return f"<g:Polygon{identity}><g:exterior>{self.ring(corners, depth)}</g:exterior>{inner}</g:Polygon>"

    def surface(self, *polygons: str) -> str:
        members = "".join(f"<g:surfaceMember>{polygon}</g:surfaceMember>" for polygon in polygons)
        return f"<lod3MultiSurface><g:MultiSurface>{members}</g:MultiSurface></lod3MultiSurface>"

    def hole(self, kind: str, corners: np.ndarray, depth: float = -0.1) -> str:
        polygon = self.surface(self.polygon(corners, depth=depth))
        return f"<{self.opening}><{kind}>{polygon}</{kind}></{self.opening}>"

    def wall(self, *parts: str, name: str = "") -> None:
        identity = f' g:id="{name}"' if name else ""
        self.parts.append(f"<boundedBy><WallSurface{identity}>{''.join(parts)}</WallSurface></boundedBy>")

    def content(self) -> bytes:
        head = f'<?xml version="1.0"?><CityModel xmlns="{self.core}" xmlns:g="{self.gml}" '
        head += 'xmlns:xlink="http://www.w3.org/1999/xlink"><cityObjectMember><Building g:id="B">'
        return f"{head}{''.join(self.parts)}</Building></cityObjectMember></CityModel>".encode()


def usual(version: int = 2, **where) -> City:
    city = City(version, **where)
    city.wall(
        city.surface(city.polygon(WALL, ARCH, DOOR)),
        city.hole(city.window, ARCH),
        city.hole(city.door, DOOR, depth=-0.3),
        name="front",
    )
    return city
