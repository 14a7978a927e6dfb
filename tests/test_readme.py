"""The README's code does what the README says."""

import re
from pathlib import Path

import pytest

import distmesh_edu as de

README = (Path(__file__).parents[1] / "README.md").read_text("utf-8")


CODE = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


def test_the_ten_lines_mesh_the_lake(capsys):
    code = CODE[0]
    assert len(code.splitlines()) <= 10
    names = {}
    with pytest.warns(de.ResolutionWarning, match="unresolved"):
        exec(code, names)
    assert "nodes" in capsys.readouterr().out
    mesh = names["mesh"]
    assert 1000 < len(mesh.p) < 1200
    assert mesh.area == pytest.approx(82_369, rel=0.01)
    assert mesh.quality.min() > 0.5
    assert mesh.quality.mean() > 0.94
    assert 20 < len(de.unresolved(mesh, names["lake"])) < 60


def test_a_star_shrinks_becomes_a_distance_and_is_meshed():
    names = {"de": de}
    exec(CODE[1], names)
    mesh = names["mesh"]
    assert mesh.converged
    assert mesh.area == pytest.approx(de.volume(names["phi"], 0.04), rel=0.05)


def test_every_file_it_links_to_exists():
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert len(links) >= 5
    for link in links:
        assert (Path(__file__).parents[1] / link).exists(), link
