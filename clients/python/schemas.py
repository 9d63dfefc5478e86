"""For tests: holds every answer and message of a cell against the document that it tells itself."""

import copy
import json

import jsonschema

import sinew


def closed(schema):
    """The same, but for objects with fields that the document does not have."""
    if isinstance(schema, list):
        return [closed(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    made = {key: closed(value) for key, value in schema.items()}
    if schema.get("type") == "object" and "properties" in schema:
        made.setdefault("additionalProperties", False)
    return made


class Schemas:
    """From `watch()` on, whatever any sinew.Cell hears is looked at."""

    def __init__(self, document):
        self.answered = set()
        self.told = set()
        self.complaints = []
        components = {"components": closed(copy.deepcopy(document["components"]))}
        make = lambda ref: jsonschema.Draft7Validator({**ref, **components})  # noqa: E731
        self._results = {one["name"]: make(one["result"]["schema"]) for one in document["methods"]}
        self._messages = {name: make(ref) for name, ref in document["x-messages"].items()}
        self._errors = {one["code"]: one for one in document["components"]["errors"].values()}
        self._refusal = make({"$ref": "#/components/schemas/Refusal"})

    def watch(self):
        call, next_message = sinew.Cell.call, sinew.Cell.next_message

        def looked_at_call(cell, method, *args, **params):
            try:
                result = call(cell, method, *args, **params)
            except sinew.Refused as error:
                self._look(self._refusal, method, error.data if error.data is not None else {})
                if error.code not in self._errors:
                    self.complaints.append(f"{method}: no error has the code {error.code}")
                raise
            self.answered.add(method)
            self._look(self._results[method], method, result)
            return result

        def looked_at_message(cell, *args):
            message = next_message(cell, *args)
            if message is not None:
                self.told.add(message["method"])
                self._look(self._messages[message["method"]], message["method"], message["params"])
            return message

        sinew.Cell.call, sinew.Cell.next_message = looked_at_call, looked_at_message

    def _look(self, validator, name, value):
        for error in validator.iter_errors(value):
            place = "/".join(str(part) for part in error.absolute_path)
            self.complaints.append(f"{name}: {place}: {error.message[:300]} in "
                                   f"{json.dumps(error.instance)[:300]}")
