"""Files of a served folder: those of the folder only, with the token only."""

from __future__ import annotations

import asyncio
import gzip
from collections.abc import Awaitable, Callable
from contextlib import suppress
from pathlib import Path

from grammarlab.pages.city.city_viewer import page_of
from grammarlab.pages.server import serving
from tests.pages.scoring.test_server import Page
from tests.pages.test_server import Echo


def visit(folder: Path, visitor: Callable[[Page], Awaitable[None]]) -> None:
    async def main() -> None:
        ready: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        task = asyncio.create_task(serving(Echo(), page_of(folder), 0, ready.set_result))
        try:
            await visitor(Page(await ready))
        finally:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task

    asyncio.run(main())


def test_files_of_the_folder_and_no_others_are_served(tmp_path: Path):
    folder = tmp_path / "city"
    (folder / "t").mkdir(parents=True)
    (folder / "t" / "0.glb").write_bytes(b"glTF")
    (folder / "t" / "1.glb").write_bytes(gzip.compress(b"glTF" * 9))
    (folder / "tileset.json").write_text("{}")
    (folder / "parcels.parquet").write_bytes(b"PAR1")
    (tmp_path / "secret.json").write_text("{}")
    (folder / "link.json").symlink_to(tmp_path / "secret.json")
    (folder / "up").symlink_to(tmp_path, target_is_directory=True)

    async def visitor(page: Page) -> None:
        async def code(name: str, query: str = page.query) -> int:
            return (await page.get(f"/folder/{name}?{query}")).code

        tile = await page.get(f"/folder/t/0.glb?{page.query}")
        assert (tile.code, tile.body, tile.headers["Content-Type"]) == (200, b"glTF", "model/gltf-binary")
        again = await page.get(f"/folder/t/0.glb?{page.query}", **{"If-None-Match": tile.headers["Etag"]})
        assert (again.code, again.body) == (304, b"")
        assert (await page.get(f"/folder/t/1.glb?{page.query}")).body == b"glTF" * 9
        assert await code("tileset.json") == 200
        assert await code("tileset.json", "token=wrong") == 403
        outside = ["../secret.json", "..%2fsecret.json", "link.json", "up/secret.json", "%2fetc%2fhostname"]
        for name in [*outside, "t/2.glb", "t", "parcels.parquet", "%00.json", "t%5c0.glb", "x" * 5000 + ".json"]:
            assert await code(name) == 404, name

    visit(folder, visitor)
