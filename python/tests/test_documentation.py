# SPDX-License-Identifier: Apache-2.0
"""Every public name says what it is: shapes, units, errors, and where it comes from."""

import ast
import inspect
import pathlib
import unittest

import palpate
from palpate import _core

try:
    from palpate import sim as _sim
except ImportError:
    _sim = None


class Documentation(unittest.TestCase):
    """Every public name says what it is, in the units it is in, and what it refuses."""

    def public(self):
        for name in palpate.__all__:
            yield name, getattr(palpate, name)

    def test_every_name_has_a_docstring(self):
        for name, value in self.public():
            self.assertTrue((inspect.getdoc(value) or "").strip(), name)
            if inspect.isclass(value):
                for member, attribute in vars(value).items():
                    if not member.startswith("_"):
                        self.assertTrue((attribute.__doc__ or "").strip(), f"{name}.{member}")

    def test_what_takes_arrays_says_shapes_and_errors(self):
        takers = [(name, value) for name, value in self.public() if callable(value)]
        takers += [(n, v.__init__) for n, v in takers if inspect.isclass(v)]
        documented = 0
        for name, value in takers:
            text = inspect.getdoc(value) or ""
            if "ArrayLike" in text or "ArrayLike" in str(getattr(value, "__nb_signature__", "")):
                self.assertRegex(text, r"\(\w+,? ?\w*\)", f"{name} says no shape")
                self.assertIn("Raises ValueError", text, name)
                documented += 1
        self.assertGreater(documented, 10)

    @unittest.skipUnless(_sim, "built without the simulator")
    def test_the_simulators_names_say_what_they_are_and_refuse(self):
        for name in set(_sim.__all__) - {"IDEAL"}:  # a dictionary
            value = getattr(_sim, name)
            self.assertTrue((inspect.getdoc(value) or "").strip(), name)
            members = vars(value).items() if inspect.isclass(value) else []
            for member, attribute in members:
                if not member.startswith("_"):
                    self.assertTrue((attribute.__doc__ or "").strip(), f"{name}.{member}")
                    self.says_errors(f"{name}.{member}", attribute)
            self.says_errors(name, value)
        stub = (pathlib.Path(palpate.__file__).parent / "_sim.pyi").read_text()
        for name in set(_sim.__all__) - {"IDEAL"}:
            self.assertRegex(stub, rf"(class|def) {name}\b")
        self.assertFalse("dict[str, object]" in stub)  # which no dict[str, float] is

    def says_errors(self, name, value):
        text = f"{inspect.getdoc(value) or ''} {getattr(value, '__nb_signature__', '')}"
        if "ArrayLike" in text or "options" in text:
            self.assertRegex(text, r"Raises \w+Error", name)

    def test_numbers_have_units(self):
        """What of a result holds numbers says in which unit, but for what has none."""
        unit = r"\b(m|mm|rad|deg|s|N|kg|kg m\^2|m\^2|m\^3|N m/rad|N m s/rad|m/s|nats?)\b"
        without = {
            "probability", "probabilities", "other", "weight", "weights", "residual_mass",
            "credible_mass", "scale", "size",
            "false_alarms", "false_inliers", "stretch", "direction", "normal", "R_table_object",
            "symmetries"}  # fmt: skip
        poses = {"T_frame_object", "T_world_mount", "T_parent_link", "T_target_source", "residual_set"}
        several = {"joints", "resolution_deg"}  # a matrix of ratios; the name says it
        found = 0
        for name, value in self.public():
            for member, attribute in vars(value).items() if inspect.isclass(value) else []:
                signature = str(getattr(getattr(attribute, "fget", None), "__nb_signature__", ""))
                if "float" in signature and member not in without | poses | several:
                    self.assertRegex(attribute.__doc__ or "", unit, f"{name}.{member}")
                    found += 1
        self.assertGreater(found, 40)

    def test_stub_and_marker_are_there(self):
        folder = pathlib.Path(palpate.__file__).parent
        self.assertTrue((folder / "py.typed").exists())
        stub = (folder / "_core.pyi").read_text()
        for name in palpate.__all__:
            if name != "envs":
                self.assertRegex(stub, rf"(class|def) {name}\b|{name}:")
        self.assertIn("numpy.typing.ArrayLike", stub)

    def test_types_in_stubs_are_types(self):
        """A class that has a property `object` cannot call a type so."""
        folder = pathlib.Path(palpate.__file__).parent
        for path in [folder / "_core.pyi"] + ([folder / "_sim.pyi"] if _sim else []):
            for kind in ast.walk(ast.parse(path.read_text())):
                if not isinstance(kind, ast.ClassDef):
                    continue
                methods = [part for part in kind.body if isinstance(part, ast.FunctionDef)]
                own = {method.name for method in methods}
                for method in methods:
                    types = [method.returns, *(argument.annotation for argument in
                             ast.walk(method.args) if isinstance(argument, ast.arg))]  # fmt: skip
                    used = {name.id for one in types if one for name in ast.walk(one)
                            if isinstance(name, ast.Name)}  # fmt: skip
                    self.assertFalse(used & own, f"{path.name}: {kind.name}.{method.name}")

    def test_type_checkers_find_the_public_names(self):
        """They read __all__ only where it is written out."""
        source = ast.parse(pathlib.Path(palpate.__file__).read_text())
        (value,) = [part.value for part in source.body if isinstance(part, ast.Assign)
                    and part.targets[0].id == "__all__"]  # fmt: skip
        self.assertEqual(ast.literal_eval(value), palpate.__all__)

    def test_all_public_names_of_the_core_are_exported(self):
        core = {name for name in dir(_core) if not name.startswith("_")}
        self.assertEqual(core, set(palpate.__all__) - {"envs"})

    def test_published_methods_name_their_source(self):
        """Whoever wants to know how it is done finds the paper or the thesis."""
        methods = {
            "localize": "Petrovskaya & Khatib 2011", "Tracker": "Bell & Cathey 1993",
            "identify": "Robert & Casella 2004", "choose_touch": "Kolchinsky & Tracey 2017",
            "contact_of_wrench": "Bicchi, Salisbury & Brock 1993", "normal_estimators": "thesis",
            "register_correspondences": "thesis", "register_clouds": "Rusu, Blodow & Beetz 2009",
            "certify": "Briales & Gonzalez-Jimenez 2017",
            "RegistrationCertificate.robust_bound": "Bustos & Chin 2018",
            "RegistrationCertificate.least_squares": "thesis",
            "StablePose.probability": "Goldberg et al. 1999",
            "ArmDescription.inverse_kinematics": "Wampler 1986",
        }  # fmt: skip
        simulated = {"plan": "Sucan, Moll & Kavraki 2012", "RelocateTasks": "Rajeswaran et al. 2018"}
        for package, sources in ((palpate, methods), (_sim, simulated if _sim else {})):
            for name, source in sources.items():
                value = package
                for part in name.split("."):
                    value = getattr(value, part)
                self.assertIn(source, " ".join(value.__doc__.split()), name)


if __name__ == "__main__":
    unittest.main()
