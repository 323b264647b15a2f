"""The devices that the driver reports."""

from types import SimpleNamespace


class System:
    @staticmethod
    def local():
        return SimpleNamespace(devices=[SimpleNamespace(name="Dev1"), SimpleNamespace(name="card")])
