# Copyright 2026 gearbox_monitor authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Read the YAML files of a user: model of the drive, parameters of a node."""
from pathlib import Path
import re

import yaml

from gearbox_monitor.drive.model import model_from_dict
from gearbox_monitor.errors import InputError
from gearbox_monitor.parameters import checked


# Parameters that every node has.
OF_ROS = ('qos_overrides', 'start_type_description_service', 'use_sim_time')


class _Loader(yaml.SafeLoader):
    """Safe loader that takes 1e-3 for a number, as YAML 1.2 does and ROS parameter files do."""


_Loader.add_implicit_resolver(
    'tag:yaml.org,2002:float',
    re.compile(r'[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)[eE][-+]?[0-9]+$'), list('-+.0123456789'))


def load_yaml(path):
    """Return the mapping in the YAML file `path`; raises InputError with file and line."""
    try:
        data = yaml.load(Path(path).read_text(encoding='utf-8'), _Loader)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a readable YAML file') from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        where = getattr(error, 'problem_mark', None)
        line = f' line {where.line + 1}:' if where else ''
        problem = getattr(error, 'problem', None) or 'not text'
        raise InputError(f'{path}:{line} {problem}, expected YAML') from None
    return data


def load_model(path):
    """Return the DriveModel of the model file `path`. Raises InputError."""
    data = load_yaml(path)
    return model_from_dict({} if data is None else data, str(path))


def save_model(path, model, comment):
    """
    Write the DriveModel `model` to the new file `path`, under `comment` (lines). See load_model.

    Raises InputError where `path` exists or cannot be written.
    """
    lines = [f'# {line}'.rstrip() for line in comment]
    text = '\n'.join(lines) + '\n' + yaml.safe_dump(
        model.to_dict(), sort_keys=False, default_flow_style=None)
    try:
        with open(path, 'x', encoding='utf-8') as file:
            file.write(text)
    except OSError as error:
        raise InputError(f'{path}: {error.strerror}, expected a new, writable file') from None


def load_parameters(path, node, table, of=''):
    """
    Return the parameters of `table` that the ROS parameter file `path` gives to `node`.

    Takes the blocks ``/**``, ``/**/node`` and `node` (with or without a namespace), in this order.
    of: a topic or node; where there are several namespaces its own is meant. Raises InputError.
    """
    data = load_yaml(path)
    if not isinstance(data, dict):
        raise InputError(f'{path}: {str(data)[:40]!r}, expected "{node}: ros__parameters: ..."')
    blocks = [block for block in data if isinstance(block, str)]
    values, several = {}, [
        block.rsplit('/', 1)[0] or '/' for block in blocks
        if re.fullmatch(rf'/([^*]*/)?{node}', block)]
    for block in sorted(blocks, key=lambda name: ('/**' not in name, '/**/' in name)):
        if block.rsplit('/', 1)[-1] not in ('**', node):
            continue
        if len(several) > 1 and '/**' not in block:
            wanted = '/' + of.rpartition('/')[0].strip('/')
            if wanted not in several:
                raise InputError(
                    f'{path}: blocks for {node} in {", ".join(several)}, expected to know whose: '
                    f'choose it with --topic {several[0]}/{node}')
            if (block.rsplit('/', 1)[0] or '/') != wanted:
                continue
        inner = data[block].get('ros__parameters') if isinstance(data[block], dict) else None
        if not isinstance(inner, dict):
            raise InputError(f'{path}: {block}: expected a block ros__parameters')
        names = {row.name for row in table}
        # /** addresses every node: what this one does not have belongs to another.
        values.update({
            k: v for k, v in inner.items() if k in names or block.rsplit('/', 1)[-1] == node
            and k.partition('.')[0] not in OF_ROS})
    checked(table, values, path)
    return values
