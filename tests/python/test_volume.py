"""Volume correction: measures, options, reports."""

import pickle

import numpy as np
import pytest

import supple


def _stretched(body):
    body.positions = body.positions * [1.5, 1, 1]
    return body.volume_report()


def test_auto_is_the_mesh_measure_for_a_closed_mesh(cube):
    body = supple.Body(cube, lattice_vertices=200)
    report = _stretched(body)
    assert report.measure == "mesh"
    assert report.rest == pytest.approx(8, rel=1e-6)
    assert report.before == pytest.approx(12, rel=1e-5)
    assert report.after == pytest.approx(8, rel=1e-5)
    assert abs(report.residual) < 1e-6
    assert report.lambda_ < 0
    assert not report.capped
    surface = supple.Mesh(body.surface(), cube.faces)
    assert surface.volume == pytest.approx(8, rel=1e-5)


def test_auto_is_the_cell_measure_for_a_bare_lattice(block):
    report = _stretched(supple.Body(block))
    assert report.measure == "cells"
    assert report.rest == pytest.approx(24 * 0.5**3, rel=1e-12)
    assert abs(report.residual) < 1e-6
    assert set(report.volumes) == {"lattice", "cells"}


@pytest.mark.parametrize("measure", ["mesh", "cells", "lattice"])
def test_each_measure_keeps_its_own_volume(cube, measure):
    options = [{"scope": "global", "field": "paper"}, {"scope": "regional"}, {"scope": "regional", "field": "cells"}]
    for volume in (measure, {"measure": measure}, *({"measure": measure} | more for more in options)):
        report = _stretched(supple.Body(cube, cell_size=0.4, volume=volume))
        assert report.measure == measure
        rest, _, after = report.volumes[measure]
        assert after == pytest.approx(rest, rel=1e-6)
        assert (report.rest, report.after) == pytest.approx((rest, after))
        assert set(report.volumes) == {"mesh", "cells", "lattice"}


def test_off_corrects_nothing(cube):
    body = supple.Body(cube, lattice_vertices=200, volume="off")
    report = _stretched(body)
    assert report.after == report.before == pytest.approx(12, rel=1e-5)
    assert report.lambda_ == 0
    assert np.allclose(body.corrected_positions(), body.positions, rtol=0, atol=1e-6)


def test_volume_options_can_be_changed_between_steps(cube):
    body = supple.Body(cube, lattice_vertices=200)
    assert body.volume_options == {"measure": "auto", "scope": "global", "field": "auto", "max_correction": 1.0}
    corrected = _stretched(body)
    body.volume_options = "off"
    assert body.volume_options["measure"] == "off"
    plain = body.volume_report()
    assert plain.after == plain.before == corrected.before
    with pytest.raises(
        ValueError, match='volume is "mass"; it must be one of "auto", "off", "lattice", "cells", "mesh"'
    ):
        body.volume_options = "mass"
    with pytest.raises(TypeError, match=r"volume must be a string .* or a dict with .*, not None"):
        body.volume_options = None
    assert body.volume_options["measure"] == "off"
    body.volume_options = {"measure": "cells", "scope": "regional"}
    again = pickle.loads(pickle.dumps(body))
    options = body.volume_options
    assert again.volume_options == options == {**options, "measure": "cells", "scope": "regional"}
    assert again.volume_report() == body.volume_report()
    body.volume_options = "auto"
    assert body.volume_report() == corrected


def test_max_correction_caps_the_correction(cube):
    report = _stretched(supple.Body(cube, lattice_vertices=200, volume={"max_correction": 0.01}))
    assert report.capped
    # The thickness is at least half a cell and at most half of the cube.
    assert -0.01 <= report.lambda_ < 0
    assert report.residual == pytest.approx(report.after / report.rest - 1, rel=1e-6)
    assert report.rest < report.after < report.before


def test_components_are_corrected_independently():
    cells = np.zeros((7, 3, 3), bool)
    cells[:3] = cells[4:] = True
    body = supple.Body(supple.Lattice.from_cells(cells, join=False))
    scale = np.where(body.lattice.indices[:, :1] <= 3, 1.2, 1.0)
    body.positions = body.positions * scale
    report = body.volume_report()
    assert len(report.components) == 2
    first, second = report.components
    assert first.lambda_ < -1e-3
    assert abs(second.lambda_) < 1e-6
    assert report.lambda_ == first.lambda_
    assert report.rest == first.rest + second.rest


def test_reports_are_immutable_and_pickle(cube):
    report = _stretched(supple.Body(cube, lattice_vertices=64))
    assert isinstance(report, supple.VolumeReport)
    assert pickle.loads(pickle.dumps(report)) == report
    with pytest.raises(AttributeError):
        report.rest = 3


@pytest.mark.parametrize(
    ("volume", "error", "message"),
    [
        ("mass", ValueError, 'volume is "mass"; it must be one of "auto",'),
        (3, TypeError, r'volume must be a string \("off" for no correction\) or a dict with .*, not int'),
        (None, TypeError, r'volume must be a string \("off" for no correction\) or a dict with .*, not None'),
        ({"measure": "cell"}, ValueError, 'volume.measure is "cell"; it must be one of "auto", "off", "lattice",'),
        ({"mesure": "cells"}, ValueError, 'volume has no key "mesure"; the nearest one is "measure"'),
        ({1: "cells"}, ValueError, 'volume has no key "1"'),
        ({"max_correction": -1}, ValueError, "volume.max_correction = -1 is out of range: .* of at least 0"),
        ({"max_correction": np.nan}, ValueError, "volume.max_correction = NaN is out of range: .* of at least 0"),
        (
            {"field": "magic"},
            ValueError,
            'volume.field is "magic"; it must be one of "auto", "surface", "cells", "paper"',
        ),
        ({"scope": "local"}, ValueError, 'volume.scope is "local"; it must be one of "global", "regional"'),
    ],
)
def test_invalid_options_are_errors(cube, volume, error, message):
    with pytest.raises(error, match=message):
        supple.Body(cube, volume=volume)


def test_the_mesh_measure_needs_a_closed_mesh(cube, block):
    with pytest.raises(ValueError, match="this body is a bare lattice: use `cells`"):
        supple.Body(block, volume="mesh")
    with pytest.raises(ValueError, match=r"3 edges of this one are open .* use `cells`"):
        supple.Body(supple.Mesh(cube.vertices, cube.faces[1:]), volume="mesh")
