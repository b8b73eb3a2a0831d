# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Ranges of parameters as the domain randomisation of a simulator: YAML, Isaac Lab, mjlab.

The events of both frameworks draw each parameter alone; a function beside them draws all
parameters of the joint together, with their correlation.
"""
from collections.abc import Callable, Sequence
from math import log
from typing import Any, NamedTuple

import yaml

from gearbox_monitor.balance.robot_effects import PAYLOAD
from gearbox_monitor.errors import InputError, unknown
from gearbox_monitor.identification.parameter_ranges import NORMAL, ParameterRanges
from gearbox_monitor.plant.effects.actuator import ACTUATOR_DELAY

ALIASES = {'isaaclab': 'isaac'}
FRICTION, VISCOUS, ARMATURE = 'Cc', 'Cv', 'm1'
DELAY, WEIGHT = 'actuator_delay.T', 'gravity.G'
MASS = f'{PAYLOAD.id}.m'  # mass that a robot holds beyond its file
JOINT = (FRICTION, VISCOUS, ARMATURE)  # that the function which draws together can write
STEP = 0.005                           # s, of the physics in the text, for the delay
RELATED = 0.3                          # correlation that is worth a sentence


class _Range(NamedTuple):
    """A range as text, and as text relative to its centre."""

    absolute: str
    relative: str
    law: str


def randomisation(ranges: ParameterRanges, to: str) -> str:
    """
    Return ranges as a text of a simulator.

    Args:
        ranges: of a new drive.
        to: yaml, isaac (isaaclab) or mjlab.

    Raises:
        InputError: another simulator.
    """
    to = ALIASES.get(to, to)
    if to not in WRITERS:
        raise InputError(f'to: {to!r}, {unknown(to, WRITERS)}')
    return WRITERS[to](ranges)


def ranges_data(ranges: ParameterRanges) -> dict[str, Any]:
    """Return ranges as plain data, the schema of the YAML file."""
    rows = {}
    for i, name in enumerate(ranges.names):
        rows[name] = {
            'unit': ranges.units[i], 'median': _rounded(ranges.centre[i]),
            'low': _rounded(ranges.low[i]), 'high': _rounded(ranges.high[i]),
            'distribution': 'lognormal' if ranges.logarithmic[i] else 'normal'}
        if ranges.between[i] == ranges.between[i]:
            rows[name]['between'] = _rounded(ranges.between[i])
    return {
        'confidence': 0.9, 'parameters': rows,
        'correlation': [[round(float(r), 3) for r in row] for row in ranges.correlation],
        'known_only_in_combination': [
            {'exponents': {k: round(v, 3) for k, v in c.exponents.items()},
             'deviation': _rounded(c.deviation)} for c in ranges.combinations],
        'sources': list(ranges.sources), 'notes': list(ranges.notes)}


def _yaml(ranges: ParameterRanges) -> str:
    head = ('# 90 % ranges of a new drive. lognormal: low and high are 5 % and 95 % of it, '
            'between is\n# the relative deviation from drive to drive; correlation: of the '
            'logarithms.\n')
    return head + yaml.safe_dump(ranges_data(ranges), sort_keys=False, width=99,
                                 allow_unicode=True)


def _rounded(value: float) -> float:
    return float(f'{value:.4g}')


def _words(ranges: ParameterRanges) -> list[str]:
    """Return comments on how the ranges were found and what they do not say."""
    lines = [f'# 90 % ranges of a new drive, from {len(ranges.sources)} estimate'
             f'{"" if len(ranges.sources) == 1 else "s"}:']
    for i, name in enumerate(ranges.names):
        lines.append(f'#   {name}: {ranges.low[i]:.4g} to {ranges.high[i]:.4g} {ranges.units[i]}, '
                     f'median {ranges.centre[i]:.4g}')
    lines += [f'# {combination}' for combination in ranges.combinations]
    for i in range(len(ranges.names)):
        lines += [f'# {ranges.names[j]} and {ranges.names[i]}: correlation '
                  f'{ranges.correlation[i, j]:.2f}' for j in range(i)
                  if abs(ranges.correlation[i, j]) > RELATED]
    return lines + [f'# {note}' for note in ranges.notes]


def _range(ranges: ParameterRanges, name: str) -> _Range | None:
    """Return the range of a parameter, None where it has none."""
    i = ranges.index(name)
    if i is None:
        return None
    low, high, centre = (float(v[i]) for v in (ranges.low, ranges.high, ranges.centre))
    law = 'log_uniform' if ranges.logarithmic[i] else 'uniform'
    shares = sorted((low / centre, high / centre)) if centre else (1.0, 1.0)
    return _Range(f'({low:.6g}, {high:.6g})', f'({shares[0]:.5g}, {shares[1]:.5g})', law)


def _weight(ranges: ParameterRanges) -> _Range | None:
    """Return the range of a payload's weight, None where its sign is open: no factor on a mass."""
    i = ranges.index(WEIGHT)
    return None if i is None or ranges.low[i] * ranges.high[i] <= 0.0 else _range(ranges, WEIGHT)


def _event(name: str, framework: str, function: str, arguments: Sequence[str],
           asset: str = 'joint_names=JOINTS') -> list[str]:
    """Return the lines of one event."""
    return [f'    {name} = EventTermCfg(', f'        func={framework}.{function},',
            "        mode='startup',", '        params={',
            f"            'asset_cfg': SceneEntityCfg(ASSET, {asset}),",
            *(f'            {argument},' for argument in arguments), '        },', '    )']


def _lacking(ranges: ParameterRanges, taken: Sequence[str]) -> list[str]:
    """Return a comment on the parameters for which there is no event."""
    missing = [name for name in ranges.names if name not in taken]
    return [f'# No event: {", ".join(missing)}. They stand above; set them in your code.'
            ] if missing else []


def _delay(ranges: ParameterRanges) -> list[str]:
    """Return lines that make steps of the physics of a delay."""
    i = ranges.index(DELAY)
    if i is None:
        return []
    return [f'DELAY = ({ranges.low[i]:.6g}, {ranges.high[i]:.6g})  # s',
            f'PHYSICS_STEP = {STEP}  # s, that of your simulation',
            'DELAY_STEPS = tuple(round(delay / PHYSICS_STEP) for delay in DELAY)']


def _together(ranges: ParameterRanges, write: Sequence[str],
              decorator: Sequence[str]) -> list[str]:
    """Return a function that draws the parameters of the joint with their correlation."""
    own = [i for i, name in enumerate(ranges.names) if name in JOINT]
    if not own:
        return []
    scale = [_deviation(ranges, i) for i in own]
    rows = ['    (' + ', '.join(f'{ranges.correlation[i, j]:.4f}' for j in own) + '),'
            for i in own]
    centre = ', '.join(f'{ranges.centre[i]:.6g}' for i in own)
    low = ', '.join(f'{ranges.low[i]:.6g}' for i in own)
    high = ', '.join(f'{ranges.high[i]:.6g}' for i in own)
    logs = ', '.join(str(ranges.logarithmic[i]) for i in own)
    return [
        '', '', f'PARAMETERS = ({", ".join(repr(ranges.names[i]) for i in own)},)',
        f'CENTRE = ({centre},)', f'LOW = ({low},)', f'HIGH = ({high},)',
        '# Of the logarithm, where a parameter has one.',
        f'DEVIATION = ({", ".join(f"{s:.6g}" for s in scale)},)',
        f'LOGARITHMIC = ({logs},)', 'CORRELATION = (', *rows, ')', '', '',
        'def draw(count, device):',
        '    """Return correlated parameters {name: [count, 1]}, within their 90 % ranges."""',
        '    values, vectors = torch.linalg.eigh(torch.tensor(CORRELATION, device=device))',
        '    factor = vectors * values.clamp(min=0.0).sqrt()',
        '    step = torch.randn(count, len(PARAMETERS), device=device) @ factor.T',
        '    out = {}',
        '    for i, name in enumerate(PARAMETERS):',
        '        move = DEVIATION[i] * step[:, i:i + 1]',
        '        value = CENTRE[i] * move.exp() if LOGARITHMIC[i] else CENTRE[i] + move',
        '        out[name] = value.clamp(LOW[i], HIGH[i])',
        '    return out', '', '', *decorator,
        'def joint_together(env, env_ids, asset_cfg):',
        '    """Set the parameters of the joint, drawn together, in each of the environments."""',
        '    if env_ids is None:',
        '        env_ids = torch.arange(env.num_envs, device=env.device)',
        '    asset = env.scene[asset_cfg.name]',
        '    value = draw(len(env_ids), env.device)', *write]


def _deviation(ranges: ParameterRanges, i: int) -> float:
    """Return the deviation of a normal with the range of the parameter at i, on its scale."""
    low, high = float(ranges.low[i]), float(ranges.high[i])
    return ((log(high) - log(low)) if ranges.logarithmic[i] else high - low) / (2.0 * NORMAL)


def _isaac(ranges: ParameterRanges) -> str:
    """Return event terms of Isaac Lab."""
    friction, viscous, armature = (_range(ranges, name) for name in JOINT)
    kp, kd, weight = _range(ranges, 'kp'), _range(ranges, 'kd'), _weight(ranges)
    events: list[str] = []

    def add(name: str, function: str, rows: dict[str, str], operation: str, law: str,
            asset: str = 'joint_names=JOINTS') -> None:
        events.extend(_event(name, 'mdp', function, [
            *(f"'{key}': {value}" for key, value in rows.items()),
            f"'operation': '{operation}'", f"'distribution': '{law}'"], asset))
    if friction:
        events += ['    # Scales static, dynamic and viscous friction of the configuration, each',
                   '    # by a draw of its own from this one range: set them to the medians.']
        add('joint_friction', 'randomize_joint_parameters',
            {'friction_distribution_params': friction.relative}, 'scale', friction.law)
    if armature:
        add('joint_armature', 'randomize_joint_parameters',
            {'armature_distribution_params': armature.absolute}, 'abs', armature.law)
    gains = {key: entry for key, entry in (('stiffness_distribution_params', kp),
                                           ('damping_distribution_params', kd)) if entry}
    if gains:
        add('actuator_gains', 'randomize_actuator_gains',
            {key: entry.absolute for key, entry in gains.items()}, 'abs',
            next(iter(gains.values())).law)
    if weight:
        add('payload', 'randomize_rigid_body_mass',
            {'mass_distribution_params': weight.relative, 'recompute_inertia': 'True'}, 'scale',
            weight.law, 'body_names=BODIES')
    if mass := _range(ranges, MASS):
        add('payload_mass', 'randomize_rigid_body_mass',
            {'mass_distribution_params': mass.absolute, 'recompute_inertia': 'True'}, 'add',
            mass.law, 'body_names=BODIES')
    write = []
    if armature:
        write += ['    asset.write_joint_armature_to_sim(', f"        value['{ARMATURE}'], "
                  'joint_ids=asset_cfg.joint_ids, env_ids=env_ids)']
    if friction:
        write += ['    asset.write_joint_friction_coefficient_to_sim(',
                  f"        joint_friction_coeff=value['{FRICTION}'],",
                  f"        joint_dynamic_friction_coeff=value['{FRICTION}'],",
                  *([f"        joint_viscous_friction_coeff=value['{VISCOUS}'],"]
                    if viscous else []),
                  '        joint_ids=asset_cfg.joint_ids, env_ids=env_ids)']
    correlated = _together(ranges, write, ()) if write else []
    varied = [*(JOINT if friction else (ARMATURE,)), 'kp', 'kd', DELAY,
             *((WEIGHT,) if weight else ()), MASS]
    delay = _delay(ranges)
    return '\n'.join([
        *_words(ranges), 'import isaaclab.envs.mdp as mdp',
        'from isaaclab.managers import EventTermCfg, SceneEntityCfg',
        'from isaaclab.utils import configclass', 'import torch', '',
        "ASSET, JOINTS, BODIES = 'robot', ['joint'], ['body']  # names in your scene",
        *delay, *(['# min_delay, max_delay = DELAY_STEPS of DelayedPDActuatorCfg']
                  if delay else []),
        *_lacking(ranges, varied), '', '', '@configclass', 'class RangeEvents:',
        '    """Each parameter alone, without correlation."""', '', *(events or ['    pass']),
        *correlated, *(['', '', '@configclass', 'class CorrelatedEvents:',
                      '    """Instead of friction and armature of RangeEvents."""', '',
                      '    joint = EventTermCfg(',
                      "        func=joint_together, mode='startup',",
                      "        params={'asset_cfg': SceneEntityCfg(ASSET, joint_names=JOINTS)})"]
                     if correlated else []), ''])


def _mjlab(ranges: ParameterRanges) -> str:
    """Return event terms of mjlab."""
    events: list[str] = []
    fields = []
    for name, event, field, function in (
            (FRICTION, 'joint_friction', 'dof_frictionloss', 'joint_friction'),
            (VISCOUS, 'joint_damping', 'dof_damping', 'joint_damping'),
            (ARMATURE, 'joint_armature', 'dof_armature', 'joint_armature')):
        if entry := _range(ranges, name):
            fields.append((name, field))
            events += _event(event, 'dr', function, [
                f"'ranges': {entry.absolute}", "'operation': 'abs'",
                f"'distribution': '{entry.law}'"])
    kp, kd, weight = _range(ranges, 'kp'), _range(ranges, 'kd'), _weight(ranges)
    if gain := kp or kd:
        events += _event('pd_gains', 'dr', 'pd_gains', [
            f"'kp_range': {kp.relative if kp else '(1.0, 1.0)'}",
            f"'kd_range': {kd.relative if kd else '(1.0, 1.0)'}", "'operation': 'scale'",
            f"'distribution': '{gain.law}'"],
            'actuator_names=JOINTS')
    if weight:
        events += _event('payload', 'dr', 'body_mass', [
            f"'ranges': {weight.relative}", "'operation': 'scale'",
            f"'distribution': '{weight.law}'"], 'body_names=BODIES')
    if mass := _range(ranges, MASS):
        events += _event('payload_mass', 'dr', 'body_mass', [
            f"'ranges': {mass.absolute}", "'operation': 'add'",
            f"'distribution': '{mass.law}'"], 'body_names=BODIES')
    delay = _delay(ranges)
    if delay:
        events += _event(ACTUATOR_DELAY.id, 'dr', 'sync_actuator_delays', [
            "'lag_range': DELAY_STEPS"], 'actuator_names=JOINTS')
    write = ['    dofs = asset.indexing.joint_v_adr[asset_cfg.joint_ids]',
             *(f"    env.sim.model.{field}[env_ids[:, None], dofs] = value['{name}']"
               for name, field in fields)]
    listed = ', '.join(repr(field) for _, field in fields)
    recompute = ', recompute=RecomputeLevel.set_const_0' if any(
        name == ARMATURE for name, _ in fields) else ''
    correlated = _together(ranges, write, [f'@requires_model_fields({listed}{recompute})'])
    body = [line[4:] if line.startswith('    ') else line for line in events]
    names = [line.split(' = ')[0] for line in body if ' = EventTermCfg(' in line]
    return '\n'.join([
        *_words(ranges), 'from mjlab.envs.mdp import dr',
        'from mjlab.managers.event_manager import (',
        '    EventTermCfg, RecomputeLevel, requires_model_fields)',
        'from mjlab.managers.scene_entity_config import SceneEntityCfg', 'import torch', '',
        "ASSET, JOINTS, BODIES = 'robot', ('joint',), ('body',)  # names in your scene",
        *delay, *_lacking(ranges, [*JOINT, 'kp', 'kd', DELAY, MASS,
                                   *((WEIGHT,) if weight else ())]), '',
        '# Each parameter alone, without correlation.', *body,
        f'EVENTS = {{{", ".join(f"{name!r}: {name}" for name in names)}}}', *correlated,
        *(['', '', '# Instead of friction, damping and armature of EVENTS.',
           'joint = EventTermCfg(',
           "    func=joint_together, mode='startup',",
           "    params={'asset_cfg': SceneEntityCfg(ASSET, joint_names=JOINTS)})",
           "CORRELATED_EVENTS = {'joint': joint}"] if correlated else []), ''])


WRITERS: dict[str, Callable[[ParameterRanges], str]] = {
    'yaml': _yaml, 'isaac': _isaac, 'mjlab': _mjlab}
