#!/usr/bin/env python3
"""Calls every method of a simulated cell and holds what comes back against the schemas that the
cell tells of itself: test_results.py SINEW-PROGRAM."""

import base64
import re
import sys
import time
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import sinew  # noqa: E402
from sinew import types  # noqa: E402
from schemas import Schemas  # noqa: E402
from served_cell import ServedCell  # noqa: E402

CELL = """title = "One of each wire"
time_scale = 5
[[robot]]
name = "learm"
robot = "learm"
profile = "bus"
[[robot]]
name = "maxarm"
robot = "maxarm"
x_mm = 3000
[[robot]]
name = "big"
robot = "bigrobotarm"
x_mm = 6000
[[robot]]
name = "link"
robot = "robot-arm-2"
wire = "link"
x_mm = 9000
[[robot]]
name = "registers"
robot = "robot-arm-2"
x_mm = 12000
[[robot]]
name = "platform"
robot = "hexapod"
x_mm = 15000
[[object]]
name = "shelf"
x_mm = -2000
y_mm = 0
z_mm = 100
length_mm = 100
width_mm = 100
height_mm = 200
[[camera]]
name = "above"
device = "simulated"
x_mm = 170
[[cube]]
color = "red"
x_mm = 170
[basket]
name = "tray"
length_mm = 100
width_mm = 100
height_mm = 40
y_mm = 200
"""
STAND = "joint base=0deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg"
# Need a fault, boards that test themselves, or all views of a calibration to answer; the answer is that
# of the other commands.
NOT_CALLED = {"robot.acknowledge", "robot.self_test", "camera.calibration.save"}


class ResultsTest(ServedCell):
    CELL = CELL

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        with sinew.connect(cls.socket) as cell:
            cls.document = cell.call("rpc.discover")
        cls.schemas = Schemas(cls.document)
        cls.schemas.watch()

    def refused(self, call, *args, **params):
        with self.assertRaises(sinew.Refused):
            call(*args, **params)

    def test_every_answer_and_message_is_as_the_document_says(self):
        with sinew.connect(self.socket) as cell:
            for part in (self.of_all, self.of_each_robot, self.programs, self.leases,
                         self.previews_and_checks, self.kept, self.records, self.procedures,
                         self.calibration):
                with self.subTest(part.__name__):
                    part(cell)
                while cell.next_message(0.01) is not None:
                    pass
        self.assertEqual([], self.schemas.complaints, "\n".join(self.schemas.complaints))
        methods = {one["name"] for one in self.document["methods"]}
        self.assertEqual(methods - self.schemas.answered, NOT_CALLED)
        self.assertEqual(set(self.document["x-messages"]), self.schemas.told)

    def calibration(self, cell):
        self.assertIn("svg", cell.call("camera.print", what="sheet")["text"])
        self.refused(cell.call, "camera.print", what="poster")
        session = cell.call("camera.calibration.begin")["session"]
        view = cell.call("camera.calibration.take", session=session)["taken"]
        self.refused(cell.call, "camera.calibration.save", session=session)
        cell.call("camera.calibration.drop", session=session, view=view)
        cell.call("camera.calibration.expect", session=session, step="sheet")
        self.assertEqual("sheet", cell.call("camera.calibration.status")["step"])
        cell.robot("learm").run("jaws 0mm")
        self.refused(cell.call, "camera.calibration.touch", robot="learm", mark="corner")
        cell.call("camera.calibration.touch", robot="learm", mark="cross1", pin_m=0.03,
                  session=session)
        cell.call("camera.calibration.drop", session=session, mark="cross1")
        cell.call("camera.calibration.end", session=session)

    def test_types_have_the_fields_that_the_document_has(self):
        schemas = self.document["components"]["schemas"]
        for name, schema in {
                "Pose": schemas["Pose"], "Joint": schemas["JointStatus"],
                "Error": schemas["Error"], "Job": schemas["Job"], "Fault": schemas["Latched"],
                "Status": schemas["Status"], "RobotDescription": schemas["RobotDescription"],
                "DescribedJoint": schemas["RobotDescription"]["properties"]["joints"]["items"],
                "CellDescription": schemas["CellDescription"], "Truth": schemas["Truth"],
                "JointTruth": schemas["Truth"]["properties"]["joints"]["items"]}.items():
            with self.subTest(name):
                fields = set(getattr(types, name).__annotations__)
                told = set(schema["properties"])
                patterns = [re.compile(one) for one in schema.get("patternProperties", {})]
                self.assertEqual(told - fields, set())
                self.assertEqual({one for one in fields - told
                                  if not any(pattern.match(one) for pattern in patterns)}, set())

    def of_all(self, cell):
        cell.call("rpc.discover")
        cell.call("cell.status")
        names = cell.call("objects.list")["objects"]
        cell.call("objects.query")
        cell.call("objects.subscribe", objects=names, rate_hz=20)
        cell.call("watch", rate_hz=20)
        self.refused(cell.call, "camera.look", camera="nobody")
        self.refused(cell.call, "camera.look", longest_px=5)
        end = time.monotonic() + 60
        while not (shot := cell.call("camera.look"))["number"] and time.monotonic() < end:
            time.sleep(0.1)
        self.assertEqual(base64.b64decode(shot["picture"])[:2], b"\xff\xd8")
        for trouble in ("covered", "none"):
            cell.call("simulation.camera", trouble=trouble)
        self.refused(cell.call, "simulation.camera", trouble="fog")
        cell.call("robot.cubes", robot="learm")
        cell.call("robot.cube_reach", robot="maxarm", edge_m=0.02)
        self.refused(cell.call, "robot.cubes", robot="big")
        cell.call("basket.move", basket="tray", x_m=0.02, y_m=0.2)
        self.refused(cell.call, "basket.move", basket="crate", x_m=0, y_m=0)
        self.refused(cell.call, "no.such")
        self.refused(cell.call, "robot.status", robot="nobody")
        self.refused(cell.call, "robot.status", robot=3)

    def of_each_robot(self, cell):
        for robot in cell.robots():
            robot.truth()
            for method in ("robot.model", "device.status", "wire.read", "job.status",
                           "procedure.status", "settings.get", "programs.list", "points.list"):
                cell.call(method, robot=robot.name)
            cell.call("settings.check", robot=robot.name, settings={})
            self.assertFalse(cell.call("settings.check", robot=robot.name,
                                       settings={"profile": "nothing"})["fine"])
            with robot.lease() as lease:
                lease.enable()
                cell.call("device.status", robot=robot.name)
                cell.call("wire.read", robot=robot.name, limit=2000)
            self.refused(cell.call, "robot.preview", robot=robot.name, joints=[9] * 6)

    def wait_for_job(self, cell, robot, phases=("done",)):
        end = time.monotonic() + 60
        while time.monotonic() < end:
            job = cell.call("job.status", robot=robot)
            if job["phase"] in phases and job["over"] == (job["phase"] in ("done", "stopped")):
                return job
            self.assertFalse(job["over"] and job["phase"] not in phases, job)
            cell.next_message(0.05)
        raise TimeoutError(str(job))

    def programs(self, cell):
        arm = cell.robot("learm")
        arm.run(STAND)
        arm.run("joint base=20deg speed=30%\nwait settled\njoint base=0deg")
        cell.call("program.run", robot="learm", single_step=True,
                  text="joint base=5deg\njoint base=0deg\njoint base=5deg")
        self.wait_for_job(cell, "learm", ("paused",))
        cell.call("program.step", robot="learm")
        time.sleep(0.5)
        cell.call("robot.resume", robot="learm")
        self.wait_for_job(cell, "learm")
        cell.call("program.run", robot="learm", text="wait 20s\njoint base=5deg")
        self.wait_for_job(cell, "learm", ("running",))
        cell.call("robot.hold", robot="learm")
        self.wait_for_job(cell, "learm", ("paused",))
        cell.stop()
        self.wait_for_job(cell, "learm", ("stopped",))
        cell.call("robot.bullride", robot="learm", duration_s=2, seed=7)
        self.wait_for_job(cell, "learm")
        # Too far, an unknown word, an unknown robot's joint.
        self.refused(arm.run, "line x=5m")
        self.refused(arm.run, "jiont base=5deg")
        self.refused(arm.run, "wait until base>100deg for 0.2s")

    def leases(self, cell):
        arm = cell.robot("learm")
        with arm.lease() as lease:
            lease.enable()
            cell.call("lease.renew")
            cell.call("robot.feed", robot="learm", share=0.5)
            lease.jog("joint", [0.1, 0, 0, 0, 0], 0.3)
            with sinew.connect(self.socket) as other:
                self.refused(other.call, "lease.take", robot="learm")
                self.refused(other.call, "robot.jog", robot="learm", frame="joint",
                             velocity=[0.1, 0, 0, 0, 0])
            cell.robot("learm").wait_until_ready()
            cell.call("robot.free_drive", robot="learm", on=True)
            cell.call("robot.free_drive", robot="learm", on=False)
            cell.call("robot.disable", robot="learm")
        with cell.robot("big").lease() as lease:
            lease.enable()
            cell.call("robot.declare", robot="big", moved="by hand, for a test")
            self.refused(cell.call, "robot.free_drive", robot="big", on=True)
        with cell.robot("platform").lease() as lease:
            lease.enable()
            cell.call("robot.nudge", robot="platform", joint="leg1", way=1e-5)
            cell.robot("platform").wait_until_ready()
        self.refused(cell.call, "robot.nudge", robot="platform", joint="leg1", way=1)
        cell.call("events.list")

    def previews_and_checks(self, cell):
        cell.call("robot.preview", robot="learm", text=STAND, samples=20)
        cell.call("robot.preview", robot="big", joints=[0.1] * 5)
        cell.call("robot.preview", robot="platform", tool=[0, 0, 0.26])
        self.refused(cell.call, "robot.preview", robot="learm", text="line z=-300mm")
        self.refused(cell.call, "robot.preview", robot="learm", joints=[0.2, 0, 0, 2.2, 0])
        check = cell.call("program.check", robot="learm",
                          text=f"{STAND}\nline x=5m\njoint base=0deg\nloop 2\nwait 1s\nend")
        self.assertEqual(check["rows"][1]["verdict"], "refused")
        self.assertFalse(cell.call("program.check", robot="learm", text="jiont 3")["fine"])
        cell.call("program.format", text="joint   base=3deg")
        self.refused(cell.call, "program.format", text="loop")
        pose = cell.call("program.export", robot="platform", text="move z=252mm", form="pos")
        cell.call("program.import", robot="platform", text=pose["text"], form="pos")
        self.refused(cell.call, "program.import", robot="learm", text="G2 X1", form="gcode")

    def kept(self, cell):
        saved = cell.call("programs.save", robot="learm", name="one", text=STAND, revision=0)
        self.refused(cell.call, "programs.save", robot="learm", name="one", text="#", revision=0)
        cell.call("programs.load", robot="learm", name="one")
        kept = Path(self.folder.name) / "kept" / "learm"  # where served_cell.py says
        self.assertEqual(cell.call("programs.list", robot="learm")["folder"], str(kept))
        self.assertTrue(any("one" in file.name for file in kept.iterdir()))
        cell.call("programs.remove", robot="learm", name="one", revision=saved["revision"])
        points = cell.call("points.list", robot="learm")
        points = cell.call("points.save", robot="learm", revision=points["revision"], points=(
            '[points.a]\nrobot = "learm"\njoints_deg = [0, 20, 40, 40, 0]\nsource = "a test"\n'
            'taught_at = "2026-11-21T10:00:00Z"\n[points.b]\nrobot = "learm"\nx_mm = 240\n'
            'y_mm = 20\nz_mm = 200\npitch_deg = 100\nroll_deg = 0\n'))
        self.assertEqual(len(points["points"]), 2)
        points = cell.call("points.rename", robot="learm", name="a", to="c",
                           revision=points["revision"])
        cell.call("points.remove", robot="learm", name="c", revision=points["revision"])
        settings = cell.call("settings.get", robot="learm")
        self.refused(cell.call, "settings.set", robot="learm", settings={"port": "nothing"},
                     revision=settings["revision"])
        cell.call("settings.set", robot="learm", settings=settings["now"],
                  revision=settings["revision"])

    def records(self, cell):
        begun = cell.call("record.start", robot="learm", title="a test")
        self.refused(cell.call, "record.start", robot="learm")
        cell.robot("learm").run("joint base=5deg")
        cell.call("record.stop", robot="learm")
        self.assertIn(begun["record"],
                      [one["record"] for one in cell.call("records.list")["records"]])
        part = cell.call("records.read", record=begun["record"])
        self.assertTrue(base64.b64decode(part["data"]).startswith(b"\x89MCAP0\r\n"))
        cell.call("records.csv", record=begun["record"])
        cell.call("records.remove", record=begun["record"])
        self.refused(cell.call, "records.read", record=begun["record"])

    def procedures(self, cell):
        for kind in ("recover", "commission"):
            procedure = cell.call("procedure.start", robot="big", kind=kind, anew=True)
            end = time.monotonic() + 60
            while procedure["phase"] != "asking" and time.monotonic() < end:
                cell.next_message(0.05)
                procedure = cell.call("procedure.status", robot="big")
            self.assertEqual(procedure["phase"], "asking", procedure)
            asked = procedure["asks"]
            self.refused(cell.call, "procedure.answer", robot="big", answer="what?")
            cell.call("procedure.answer", robot="big", answer={
                "words": (asked["choices"] or ["none"])[0], "amount": "done",
                "place": "home"}.get(asked["kind"], asked["kind"]))
            try:
                cell.call("procedure.back", robot="big")
            except sinew.Refused:
                pass  # at its first step, or while something goes on
            cell.call("procedure.cancel", robot="big")
            while not cell.call("procedure.status", robot="big")["over"]:
                cell.next_message(0.05)


if __name__ == "__main__":
    ServedCell.PROGRAM = str(Path(sys.argv.pop(1)).resolve())
    unittest.main(verbosity=2)
