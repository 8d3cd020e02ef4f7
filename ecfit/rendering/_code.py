"""Temporary: until ecfit.export is merged."""

from ecfit.expressions.node import topological

_W = {"neg": "-{0}", "add": "{0} + {1}", "sub": "{0} - {1}", "mul": "{0} * {1}", "div": "{0} / {1}",
      "sqrt": "xp.sqrt({0})", "exp": "xp.exp({0})", "exp2": "xp.power(2.0, {0})", "log": "xp.log({0})",
      "abs": "xp.abs({0})", "min": "xp.minimum({0}, {1})", "max": "xp.maximum({0}, {1})"}


def code(a, lang, *, name):
    root = a.expression()
    lines, names = [f"def {name}({', '.join(a.variables)}, xp):"], {}
    for i, node in enumerate(topological([root])):
        args = [names[id(x)] for x in node.args]
        if node.op == "const":
            names[id(node)] = repr(float(node.value)) if node.value >= 0 else f"({float(node.value)!r})"
            continue
        if node.op == "var":
            names[id(node)] = node.name
            continue
        if node.op == "pow":
            text = f"xp.power({args[0]}, {node.value!r})"
        else:
            text = _W[node.op].format(*args)
        names[id(node)] = f"t{i}"
        lines.append(f"    t{i} = {text}")
    lines.append(f"    return {names[id(root)]}")
    return "\n".join(lines) + "\n"
