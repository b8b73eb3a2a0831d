# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
What the reader of MJCF files does with each array of mujoco.MjModel: the list that it is held to.

An array is read (it becomes a value of a joint or of its actuator), refused where it acts on the
joint and is not its default, or irrelevant for the motion.
"""
from typing import NamedTuple

READ, REFUSED, IRRELEVANT = ('read', 'refused', 'irrelevant')


class ArrayTreatment(NamedTuple):
    """What becomes of an array of MjModel, or of an option: its kind and the reason."""

    kind: str
    reason: str


def _decided(kind: str, reason: str, names: str) -> dict[str, ArrayTreatment]:
    return {name: ArrayTreatment(kind, reason) for name in names.split()}


# ---------------------------------------------------------------------- the table


DECISIONS: dict[str, ArrayTreatment] = {
    # joints
    **_decided(READ, 'inertia, place and axis of what moves, through the inertia matrix', (
        'jnt_pos jnt_axis body_pos body_quat body_ipos body_iquat body_mass body_inertia '
        'dof_M0 dof_invweight0 body_invweight0 body_subtreemass')),
    **_decided(READ, 'armature: inertia of the motor', 'dof_armature actuator_armature'),
    **_decided(READ, 'weight: force of gravity over the position', 'body_gravcomp '
               'jnt_actgravcomp ngravcomp flg_gravcomp opt.gravity'),
    **_decided(READ, 'spring to the ground', 'jnt_stiffness qpos_spring'),
    **_decided(READ, 'viscous friction', 'dof_damping actuator_damping'),
    **_decided(READ, 'Coulomb friction and its law', 'dof_frictionloss dof_solref dof_solimp'),
    **_decided(READ, 'positions', 'jnt_qposadr jnt_dofadr jnt_bodyid qpos0 key_qpos nkey '
               'dof_bodyid dof_jntid dof_parentid body_parentid body_jntadr body_jntnum '
               'body_dofadr body_dofnum body_rootid body_treeid body_weldid'),
    **_decided(READ, 'range that a recording has to keep to', 'jnt_limited jnt_range'),
    **_decided(READ, 'limit of the torque', 'jnt_actfrclimited jnt_actfrcrange'),
    **_decided(REFUSED, 'hinge and slide are read', 'jnt_type'),
    **_decided(REFUSED, 'terms of higher order', 'jnt_stiffnesspoly dof_dampingpoly '
               'actuator_dampingpoly'),
    **_decided(REFUSED, 'a spring that yields', 'jnt_springyield'),
    **_decided(IRRELEVANT, 'state of springs that yield, which are refused', 'jnt_plasticadr '
               'tendon_plasticadr nplastic key_plastic'),
    **_decided(IRRELEVANT, 'how hard an end stop is: a recording keeps clear of it', 'jnt_solref '
               'jnt_solimp jnt_margin'),
    **_decided(IRRELEVANT, 'sleep and scale of angles, which moves nothing', 'dof_length '
               'tree_sleep_policy'),
    # actuators
    **_decided(READ, 'actuator: its force, limits, lag and delay', (
        'actuator_trntype actuator_trnid actuator_dyntype actuator_gaintype actuator_biastype '
        'actuator_dynprm actuator_gainprm actuator_biasprm actuator_gear actuator_ctrllimited '
        'actuator_ctrlrange actuator_forcelimited actuator_forcerange actuator_delay '
        'actuator_history actuator_ctrlnum actuator_ctrladr actuator_ctrlspec actuator_actnum '
        'actuator_outadr actuator_outnum actuator_group opt.disableactuator jnt_actuatorid')),
    **_decided(REFUSED, 'activations with limits, or that act early', 'actuator_actlimited '
               'actuator_actrange actuator_actearly'),
    **_decided(REFUSED, 'plug-ins', 'actuator_plugin body_plugin plugin nplugin'),
    **_decided(IRRELEVANT, 'of transmissions that are refused', 'actuator_cranklength '
               'actuator_lengthrange actuator_acc0 actuator_length0'),
    **_decided(IRRELEVANT, 'addresses', 'actuator_actadr actuator_historyadr'),
    # tendons and constraints
    **_decided(REFUSED, 'a tendon over the joint, unless it is the gearbox', (
        'tendon_stiffness tendon_stiffnesspoly tendon_damping tendon_dampingpoly '
        'tendon_armature tendon_frictionloss tendon_limited tendon_springyield '
        'tendon_lengthspring tendon_actuatorid')),
    **_decided(IRRELEVANT, 'of tendons that are refused, or how they lie', (
        'tendon_type tendon_adr tendon_num tendon_range tendon_margin tendon_solref_lim '
        'tendon_solimp_lim tendon_solref_fri tendon_solimp_fri tendon_actfrclimited '
        'tendon_actfrcrange tendon_length0 tendon_invweight0 tendon_treenum tendon_treeid '
        'wrap_type wrap_objid wrap_prm ten_J_rownnz ten_J_rowadr ten_J_colind')),
    **_decided(REFUSED, 'a constraint between what the joint moves and the rest', 'eq_type '
               'eq_obj1id eq_obj2id eq_objtype eq_active0'),
    **_decided(IRRELEVANT, 'of constraints that are refused', 'eq_data eq_solref eq_solimp'),
    **_decided(REFUSED, 'deformable bodies', 'nflex'),
    # the options
    **_decided(READ, 'steps', 'opt.timestep opt.integrator disable.EULERDAMP'),
    **_decided(READ, 'switches of forces', (
        'disable.CONSTRAINT disable.EQUALITY disable.FRICTIONLOSS disable.SPRING disable.DAMPER '
        'disable.GRAVITY disable.CLAMPCTRL disable.ACTUATION disable.REFSAFE enable.DIAGEXACT')),
    **_decided(REFUSED, 'a medium that brakes bodies', 'opt.density opt.viscosity'),
    **_decided(IRRELEVANT, 'wind acts through a medium, which is refused', 'opt.wind'),
    **_decided(REFUSED, 'a solver that changes friction, or stops before it holds',
               'opt.noslip_iterations opt.ls_iterations'),
    **_decided(REFUSED, 'bodies that fall asleep', 'enable.SLEEP'),
    **_decided(IRRELEVANT, 'of sleep, which is refused', 'opt.sleep_tolerance'),
    **_decided(IRRELEVANT, 'friction of one joint needs no iterations', (
        'opt.solver opt.iterations opt.tolerance opt.ls_tolerance '
        'opt.noslip_tolerance opt.jacobian disable.WARMSTART disable.ISLAND')),
    **_decided(IRRELEVANT, 'of contacts: a recording keeps clear of them', (
        'opt.cone opt.impratio opt.o_margin opt.o_solref opt.o_solimp opt.o_friction '
        'opt.ccd_iterations opt.ccd_tolerance opt.sdf_initpoints opt.sdf_iterations '
        'disable.LIMIT disable.CONTACT disable.FILTERPARENT disable.MIDPHASE disable.NATIVECCD '
        'disable.MULTICCD enable.OVERRIDE enable.IPC enable.SPECULATIVE flg_surfacevel '
        'flg_adhesion')),
    **_decided(IRRELEVANT, 'what is measured or computed beside the motion', (
        'opt.magnetic disable.SENSOR disable.AUTORESET enable.ENERGY enable.FWDINV '
        'enable.INVDISCRETE')),
    # sensors
    **_decided(READ, 'delay of the reading of a joint', 'sensor_type sensor_objid sensor_delay '
               'sensor_history'),
    **_decided(IRRELEVANT, 'of readings: recordings have their own noise', (
        'sensor_adr sensor_cutoff sensor_datatype sensor_dim sensor_historyadr sensor_interval '
        'sensor_intprm sensor_needstage sensor_noise sensor_objtype sensor_plugin sensor_refid '
        'sensor_reftype')),
    # bodies and shapes
    **_decided(IRRELEVANT, 'of contacts: a recording keeps clear of them', (
        'body_contype body_conaffinity body_margin body_geomadr body_geomnum body_bvhadr '
        'body_bvhnum geom_adhesion geom_condim geom_conaffinity geom_contype geom_dataid '
        'geom_friction geom_gap geom_margin geom_pos geom_quat geom_priority geom_rbound '
        'geom_aabb geom_sameframe geom_size geom_solimp geom_solmix geom_solref geom_surfacevel '
        'geom_type geom_bodyid pair_adhesion pair_dim pair_friction pair_gap pair_geom1 '
        'pair_geom2 pair_margin pair_signature pair_solimp pair_solref pair_solreffriction '
        'exclude_signature npair nexclude')),
    **_decided(IRRELEVANT, 'drag of a medium, which is refused', 'geom_fluid'),
    **_decided(IRRELEVANT, 'shortcuts of the computation', 'body_sameframe body_simple '
               'dof_simplenum dof_Madr dof_treeid tree_bodyadr tree_bodynum tree_dofadr '
               'tree_dofnum'),
    **_decided(IRRELEVANT, 'bodies that are placed from outside', 'body_mocapid nmocap key_mpos '
               'key_mquat'),
    **_decided(IRRELEVANT, 'further values of a keyframe: a recording begins where it begins',
               'key_qvel key_act key_ctrl key_time'),
    **_decided(IRRELEVANT, 'drawing', 'geom_castshadow geom_group geom_matid geom_plugin '
               'geom_rgba jnt_group tendon_group tendon_matid tendon_rgba tendon_width '
               'site_rgba site_group site_matid site_size site_type'),
    **_decided(IRRELEVANT, 'places for what is refused or drawn', 'site_bodyid site_dataid '
               'site_pos site_quat site_sameframe'),
    **_decided(IRRELEVANT, 'data that the simulation does not read', (
        'body_user geom_user jnt_user actuator_user sensor_user site_user tendon_user cam_user '
        'names names_map paths signature stat vis opt')),
    **_decided(IRRELEVANT, 'sizes', (
        'nq nv nu nactuator nout na nbody nbvh nbvhstatic nbvhdynamic noct njnt ntree nM nB nC '
        'nD ngeom nsite ncam nlight nmat ntex neq ntendon nJten nwrap nsensor nnames npaths '
        'nnames_map nJmom nemax njmax nconmax narena nbuffer nuserdata nsensordata nhistory '
        'npluginattr npluginstate nefm0dof nefm0L nefmCvert nJfe')),
}
# First parts of names of what is drawn, is the shape of something, or holds its data.
FAMILIES = {
    'cam_': 'cameras', 'light_': 'lights', 'mat_': 'materials', 'tex_': 'textures',
    'skin_': 'skins', 'bvh_': 'volumes of shapes', 'oct_': 'volumes of shapes',
    'mesh_': 'shapes', 'hfield_': 'shapes', 'numeric_': 'data of the user',
    'text_': 'data of the user', 'tuple_': 'data of the user', 'name_': 'names',
    'plugin_': 'plug-ins, which are refused', 'flex': 'deformable bodies, which are refused',
    'efm0_': 'deformable bodies, which are refused', 'efmC_': 'deformable bodies',
    'B_': 'places in a sparse matrix', 'M_': 'places in a sparse matrix',
    'D_': 'places in a sparse matrix', 'map': 'places in a sparse matrix',
    'nflex': 'sizes', 'nmesh': 'sizes', 'nskin': 'sizes', 'nhfield': 'sizes', 'ntex': 'sizes',
    'nnumeric': 'sizes', 'ntext': 'sizes', 'ntuple': 'sizes', 'nuser_': 'sizes',
    'npolygon': 'sizes'}


def decision(name: str) -> ArrayTreatment | None:
    """Return what is decided about `name` of MjModel, 'opt.x', 'disable.X'; None: nothing."""
    if name in DECISIONS:
        return DECISIONS[name]
    return next((ArrayTreatment(IRRELEVANT, reason) for first, reason in FAMILIES.items()
                 if name.startswith(first)), None)
