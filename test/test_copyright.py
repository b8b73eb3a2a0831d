import pytest

main = pytest.importorskip('ament_copyright.main', reason='ament_copyright comes with apt').main


@pytest.mark.copyright
@pytest.mark.linter
def test_copyright():
    assert main(argv=['.', 'test']) == 0, 'Found errors'
